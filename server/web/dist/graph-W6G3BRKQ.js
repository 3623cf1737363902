import{a as Ke,b as It,c as Qe}from"./chunk-E2PRJHYB.js";import{B as Pt,C as kt,D as Nt,L as Ft,N as ne,d as Lt,e as Ze,f as we,x as $e}from"./chunk-AESBINHI.js";import{a as Dt,b as ie}from"./chunk-FA5DWUQ7.js";import{b as fe}from"./chunk-SQE76S5B.js";function Yr(i,n){if(typeof i!="object"||!i)return i;var r=i[Symbol.toPrimitive];if(r!==void 0){var e=r.call(i,n||"default");if(typeof e!="object")return e;throw new TypeError("@@toPrimitive must return a primitive value.")}return(n==="string"?String:Number)(i)}function ue(i){var n=Yr(i,"string");return typeof n=="symbol"?n:n+""}function G(i,n){if(!(i instanceof n))throw new TypeError("Cannot call a class as a function")}function Ot(i,n){for(var r=0;r<n.length;r++){var e=n[r];e.enumerable=e.enumerable||!1,e.configurable=!0,"value"in e&&(e.writable=!0),Object.defineProperty(i,ue(e.key),e)}}function z(i,n,r){return n&&Ot(i.prototype,n),r&&Ot(i,r),Object.defineProperty(i,"prototype",{writable:!1}),i}function le(i){return le=Object.setPrototypeOf?Object.getPrototypeOf.bind():function(n){return n.__proto__||Object.getPrototypeOf(n)},le(i)}function Gt(){try{var i=!Boolean.prototype.valueOf.call(Reflect.construct(Boolean,[],function(){}))}catch{}return(Gt=function(){return!!i})()}function qr(i){if(i===void 0)throw new ReferenceError("this hasn't been initialised - super() hasn't been called");return i}function Zr(i,n){if(n&&(typeof n=="object"||typeof n=="function"))return n;if(n!==void 0)throw new TypeError("Derived constructors may only return object or undefined");return qr(i)}function H(i,n,r){return n=le(n),Zr(i,Gt()?Reflect.construct(n,r||[],le(i).constructor):n.apply(i,r))}function Je(i,n){return Je=Object.setPrototypeOf?Object.setPrototypeOf.bind():function(r,e){return r.__proto__=e,r},Je(i,n)}function V(i,n){if(typeof n!="function"&&n!==null)throw new TypeError("Super expression must either be null or a function");i.prototype=Object.create(n&&n.prototype,{constructor:{value:i,writable:!0,configurable:!0}}),Object.defineProperty(i,"prototype",{writable:!1}),n&&Je(i,n)}function $r(i){if(Array.isArray(i))return i}function Kr(i,n){var r=i==null?null:typeof Symbol<"u"&&i[Symbol.iterator]||i["@@iterator"];if(r!=null){var e,t,a,o,s=[],l=!0,u=!1;try{if(a=(r=r.call(i)).next,n===0){if(Object(r)!==r)return;l=!1}else for(;!(l=(e=a.call(r)).done)&&(s.push(e.value),s.length!==n);l=!0);}catch(h){u=!0,t=h}finally{try{if(!l&&r.return!=null&&(o=r.return(),Object(o)!==o))return}finally{if(u)throw t}}return s}}function Le(i,n){(n==null||n>i.length)&&(n=i.length);for(var r=0,e=Array(n);r<n;r++)e[r]=i[r];return e}function rt(i,n){if(i){if(typeof i=="string")return Le(i,n);var r={}.toString.call(i).slice(8,-1);return r==="Object"&&i.constructor&&(r=i.constructor.name),r==="Map"||r==="Set"?Array.from(i):r==="Arguments"||/^(?:Ui|I)nt(?:8|16|32)(?:Clamped)?Array$/.test(r)?Le(i,n):void 0}}function Qr(){throw new TypeError(`Invalid attempt to destructure non-iterable instance.
In order to be iterable, non-array objects must have a [Symbol.iterator]() method.`)}function ae(i,n){return $r(i)||Kr(i,n)||rt(i,n)||Qr()}var Ae={black:"#000000",silver:"#C0C0C0",gray:"#808080",grey:"#808080",white:"#FFFFFF",maroon:"#800000",red:"#FF0000",purple:"#800080",fuchsia:"#FF00FF",green:"#008000",lime:"#00FF00",olive:"#808000",yellow:"#FFFF00",navy:"#000080",blue:"#0000FF",teal:"#008080",aqua:"#00FFFF",darkblue:"#00008B",mediumblue:"#0000CD",darkgreen:"#006400",darkcyan:"#008B8B",deepskyblue:"#00BFFF",darkturquoise:"#00CED1",mediumspringgreen:"#00FA9A",springgreen:"#00FF7F",cyan:"#00FFFF",midnightblue:"#191970",dodgerblue:"#1E90FF",lightseagreen:"#20B2AA",forestgreen:"#228B22",seagreen:"#2E8B57",darkslategray:"#2F4F4F",darkslategrey:"#2F4F4F",limegreen:"#32CD32",mediumseagreen:"#3CB371",turquoise:"#40E0D0",royalblue:"#4169E1",steelblue:"#4682B4",darkslateblue:"#483D8B",mediumturquoise:"#48D1CC",indigo:"#4B0082",darkolivegreen:"#556B2F",cadetblue:"#5F9EA0",cornflowerblue:"#6495ED",rebeccapurple:"#663399",mediumaquamarine:"#66CDAA",dimgray:"#696969",dimgrey:"#696969",slateblue:"#6A5ACD",olivedrab:"#6B8E23",slategray:"#708090",slategrey:"#708090",lightslategray:"#778899",lightslategrey:"#778899",mediumslateblue:"#7B68EE",lawngreen:"#7CFC00",chartreuse:"#7FFF00",aquamarine:"#7FFFD4",skyblue:"#87CEEB",lightskyblue:"#87CEFA",blueviolet:"#8A2BE2",darkred:"#8B0000",darkmagenta:"#8B008B",saddlebrown:"#8B4513",darkseagreen:"#8FBC8F",lightgreen:"#90EE90",mediumpurple:"#9370DB",darkviolet:"#9400D3",palegreen:"#98FB98",darkorchid:"#9932CC",yellowgreen:"#9ACD32",sienna:"#A0522D",brown:"#A52A2A",darkgray:"#A9A9A9",darkgrey:"#A9A9A9",lightblue:"#ADD8E6",greenyellow:"#ADFF2F",paleturquoise:"#AFEEEE",lightsteelblue:"#B0C4DE",powderblue:"#B0E0E6",firebrick:"#B22222",darkgoldenrod:"#B8860B",mediumorchid:"#BA55D3",rosybrown:"#BC8F8F",darkkhaki:"#BDB76B",mediumvioletred:"#C71585",indianred:"#CD5C5C",peru:"#CD853F",chocolate:"#D2691E",tan:"#D2B48C",lightgray:"#D3D3D3",lightgrey:"#D3D3D3",thistle:"#D8BFD8",orchid:"#DA70D6",goldenrod:"#DAA520",palevioletred:"#DB7093",crimson:"#DC143C",gainsboro:"#DCDCDC",plum:"#DDA0DD",burlywood:"#DEB887",lightcyan:"#E0FFFF",lavender:"#E6E6FA",darksalmon:"#E9967A",violet:"#EE82EE",palegoldenrod:"#EEE8AA",lightcoral:"#F08080",khaki:"#F0E68C",aliceblue:"#F0F8FF",honeydew:"#F0FFF0",azure:"#F0FFFF",sandybrown:"#F4A460",wheat:"#F5DEB3",beige:"#F5F5DC",whitesmoke:"#F5F5F5",mintcream:"#F5FFFA",ghostwhite:"#F8F8FF",salmon:"#FA8072",antiquewhite:"#FAEBD7",linen:"#FAF0E6",lightgoldenrodyellow:"#FAFAD2",oldlace:"#FDF5E6",magenta:"#FF00FF",deeppink:"#FF1493",orangered:"#FF4500",tomato:"#FF6347",hotpink:"#FF69B4",coral:"#FF7F50",darkorange:"#FF8C00",lightsalmon:"#FFA07A",orange:"#FFA500",lightpink:"#FFB6C1",pink:"#FFC0CB",gold:"#FFD700",peachpuff:"#FFDAB9",navajowhite:"#FFDEAD",moccasin:"#FFE4B5",bisque:"#FFE4C4",mistyrose:"#FFE4E1",blanchedalmond:"#FFEBCD",papayawhip:"#FFEFD5",lavenderblush:"#FFF0F5",seashell:"#FFF5EE",cornsilk:"#FFF8DC",lemonchiffon:"#FFFACD",floralwhite:"#FFFAF0",snow:"#FFFAFA",lightyellow:"#FFFFE0",ivory:"#FFFFF0"};var zt=new Int8Array(4),et=new Int32Array(zt.buffer,0,1),Jr=new Float32Array(zt.buffer,0,1),ei=/^\s*rgba?\s*\(/,ti=/^\s*rgba?\s*\(\s*([0-9]*)\s*,\s*([0-9]*)\s*,\s*([0-9]*)(?:\s*,\s*(.*)?)?\)\s*$/;function Mt(i){var n=0,r=0,e=0,t=1;if(i[0]==="#")i.length===4?(n=parseInt(i.charAt(1)+i.charAt(1),16),r=parseInt(i.charAt(2)+i.charAt(2),16),e=parseInt(i.charAt(3)+i.charAt(3),16)):(n=parseInt(i.charAt(1)+i.charAt(2),16),r=parseInt(i.charAt(3)+i.charAt(4),16),e=parseInt(i.charAt(5)+i.charAt(6),16)),i.length===9&&(t=parseInt(i.charAt(7)+i.charAt(8),16)/255);else if(ei.test(i)){var a=i.match(ti);a&&(n=+a[1],r=+a[2],e=+a[3],a[4]&&(t=+a[4]))}return{r:n,g:r,b:e,a:t}}var ge={};for(_e in Ae)ge[_e]=q(Ae[_e]),ge[Ae[_e]]=ge[_e];var _e;function it(i,n,r,e,t){return et[0]=e<<24|r<<16|n<<8|i,t&&(et[0]=et[0]&4278190079),Jr[0]}function q(i){if(i=i.toLowerCase(),typeof ge[i]<"u")return ge[i];var n=Mt(i),r=n.r,e=n.g,t=n.b,a=n.a;a=a*255|0;var o=it(r,e,t,a,!0);return ge[i]=o,o}var tt={};function Pe(i){if(typeof tt[i]<"u")return tt[i];var n=(i&16711680)>>>16,r=(i&65280)>>>8,e=i&255,t=255,a=it(n,r,e,t,!0);return tt[i]=a,a}function ke(i,n,r,e){return r+(n<<8)+(i<<16)}function Ne(i,n,r,e,t,a){var o=Math.floor(r/a*t),s=Math.floor(i.drawingBufferHeight/a-e/a*t),l=new Uint8Array(4);i.bindFramebuffer(i.FRAMEBUFFER,n),i.readPixels(o,s,1,1,i.RGBA,i.UNSIGNED_BYTE,l);var u=ae(l,4),h=u[0],c=u[1],f=u[2],v=u[3];return[h,c,f,v]}function m(i,n,r){return(n=ue(n))in i?Object.defineProperty(i,n,{value:r,enumerable:!0,configurable:!0,writable:!0}):i[n]=r,i}function Ut(i,n){var r=Object.keys(i);if(Object.getOwnPropertySymbols){var e=Object.getOwnPropertySymbols(i);n&&(e=e.filter(function(t){return Object.getOwnPropertyDescriptor(i,t).enumerable})),r.push.apply(r,e)}return r}function S(i){for(var n=1;n<arguments.length;n++){var r=arguments[n]!=null?arguments[n]:{};n%2?Ut(Object(r),!0).forEach(function(e){m(i,e,r[e])}):Object.getOwnPropertyDescriptors?Object.defineProperties(i,Object.getOwnPropertyDescriptors(r)):Ut(Object(r)).forEach(function(e){Object.defineProperty(i,e,Object.getOwnPropertyDescriptor(r,e))})}return i}function ri(i,n){for(;!{}.hasOwnProperty.call(i,n)&&(i=le(i))!==null;);return i}function at(){return at=typeof Reflect<"u"&&Reflect.get?Reflect.get.bind():function(i,n,r){var e=ri(i,n);if(e){var t=Object.getOwnPropertyDescriptor(e,n);return t.get?t.get.call(arguments.length<3?i:r):t.value}},at.apply(null,arguments)}function Xt(i,n,r,e){var t=at(le(1&e?i.prototype:i),n,r);return 2&e&&typeof t=="function"?function(a){return t.apply(r,a)}:t}function Yt(i){return i.normalized?1:i.size}function Fe(i){var n=0;return i.forEach(function(r){return n+=Yt(r)}),n}function qt(i,n,r){var e=i==="VERTEX"?n.VERTEX_SHADER:n.FRAGMENT_SHADER,t=n.createShader(e);if(t===null)throw new Error("loadShader: error while creating the shader");n.shaderSource(t,r),n.compileShader(t);var a=n.getShaderParameter(t,n.COMPILE_STATUS);if(!a){var o=n.getShaderInfoLog(t);throw n.deleteShader(t),new Error(`loadShader: error while compiling the shader:
`.concat(o,`
`).concat(r))}return t}function Zt(i,n){return qt("VERTEX",i,n)}function $t(i,n){return qt("FRAGMENT",i,n)}function Kt(i,n){var r=i.createProgram();if(r===null)throw new Error("loadProgram: error while creating the program.");var e,t;for(e=0,t=n.length;e<t;e++)i.attachShader(r,n[e]);i.linkProgram(r);var a=i.getProgramParameter(r,i.LINK_STATUS);if(!a){var o=i.getProgramInfoLog(r);throw i.deleteProgram(r),new Error("loadProgram: error while linking the program: ".concat(o))}return r}function ot(i){var n=i.gl,r=i.buffer,e=i.program,t=i.vertexShader,a=i.fragmentShader;n.deleteShader(t),n.deleteShader(a),n.deleteProgram(e),n.deleteBuffer(r)}var Bt=`#define PICKING_MODE
`,ii=m(m(m(m(m(m(m(m({},WebGL2RenderingContext.BOOL,1),WebGL2RenderingContext.BYTE,1),WebGL2RenderingContext.UNSIGNED_BYTE,1),WebGL2RenderingContext.SHORT,2),WebGL2RenderingContext.UNSIGNED_SHORT,2),WebGL2RenderingContext.INT,4),WebGL2RenderingContext.UNSIGNED_INT,4),WebGL2RenderingContext.FLOAT,4);var st=(function(){function i(n,r,e){G(this,i),m(this,"array",new Float32Array),m(this,"constantArray",new Float32Array),m(this,"capacity",0),m(this,"verticesCount",0);var t=this.getDefinition();if(this.VERTICES=t.VERTICES,this.VERTEX_SHADER_SOURCE=t.VERTEX_SHADER_SOURCE,this.FRAGMENT_SHADER_SOURCE=t.FRAGMENT_SHADER_SOURCE,this.UNIFORMS=t.UNIFORMS,this.ATTRIBUTES=t.ATTRIBUTES,this.METHOD=t.METHOD,this.CONSTANT_ATTRIBUTES="CONSTANT_ATTRIBUTES"in t?t.CONSTANT_ATTRIBUTES:[],this.CONSTANT_DATA="CONSTANT_DATA"in t?t.CONSTANT_DATA:[],this.isInstanced="CONSTANT_ATTRIBUTES"in t,this.ATTRIBUTES_ITEMS_COUNT=Fe(this.ATTRIBUTES),this.STRIDE=this.VERTICES*this.ATTRIBUTES_ITEMS_COUNT,this.renderer=e,this.normalProgram=this.getProgramInfo("normal",n,t.VERTEX_SHADER_SOURCE,t.FRAGMENT_SHADER_SOURCE,null),this.pickProgram=r?this.getProgramInfo("pick",n,Bt+t.VERTEX_SHADER_SOURCE,Bt+t.FRAGMENT_SHADER_SOURCE,r):null,this.isInstanced){var a=Fe(this.CONSTANT_ATTRIBUTES);if(this.CONSTANT_DATA.length!==this.VERTICES)throw new Error("Program: error while getting constant data (expected ".concat(this.VERTICES," items, received ").concat(this.CONSTANT_DATA.length," instead)"));this.constantArray=new Float32Array(this.CONSTANT_DATA.length*a);for(var o=0;o<this.CONSTANT_DATA.length;o++){var s=this.CONSTANT_DATA[o];if(s.length!==a)throw new Error("Program: error while getting constant data (one vector has ".concat(s.length," items instead of ").concat(a,")"));for(var l=0;l<s.length;l++)this.constantArray[o*a+l]=s[l]}this.STRIDE=this.ATTRIBUTES_ITEMS_COUNT}}return z(i,[{key:"kill",value:function(){ot(this.normalProgram),this.pickProgram&&(ot(this.pickProgram),this.pickProgram=null)}},{key:"getProgramInfo",value:function(r,e,t,a,o){var s=this.getDefinition(),l=e.createBuffer();if(l===null)throw new Error("Program: error while creating the WebGL buffer.");var u=Zt(e,t),h=$t(e,a),c=Kt(e,[u,h]),f={};s.UNIFORMS.forEach(function(b){var R=e.getUniformLocation(c,b);R&&(f[b]=R)});var v={};s.ATTRIBUTES.forEach(function(b){v[b.name]=e.getAttribLocation(c,b.name)});var T;if("CONSTANT_ATTRIBUTES"in s&&(s.CONSTANT_ATTRIBUTES.forEach(function(b){v[b.name]=e.getAttribLocation(c,b.name)}),T=e.createBuffer(),T===null))throw new Error("Program: error while creating the WebGL constant buffer.");return{name:r,program:c,gl:e,frameBuffer:o,buffer:l,constantBuffer:T||{},uniformLocations:f,attributeLocations:v,isPicking:r==="pick",vertexShader:u,fragmentShader:h}}},{key:"bindProgram",value:function(r){var e=this,t=0,a=r.gl,o=r.buffer;this.isInstanced?(a.bindBuffer(a.ARRAY_BUFFER,r.constantBuffer),t=0,this.CONSTANT_ATTRIBUTES.forEach(function(s){return t+=e.bindAttribute(s,r,t,!1)}),a.bufferData(a.ARRAY_BUFFER,this.constantArray,a.STATIC_DRAW),a.bindBuffer(a.ARRAY_BUFFER,r.buffer),t=0,this.ATTRIBUTES.forEach(function(s){return t+=e.bindAttribute(s,r,t,!0)}),a.bufferData(a.ARRAY_BUFFER,this.array,a.DYNAMIC_DRAW)):(a.bindBuffer(a.ARRAY_BUFFER,o),t=0,this.ATTRIBUTES.forEach(function(s){return t+=e.bindAttribute(s,r,t)}),a.bufferData(a.ARRAY_BUFFER,this.array,a.DYNAMIC_DRAW)),a.bindBuffer(a.ARRAY_BUFFER,null)}},{key:"unbindProgram",value:function(r){var e=this;this.isInstanced?(this.CONSTANT_ATTRIBUTES.forEach(function(t){return e.unbindAttribute(t,r,!1)}),this.ATTRIBUTES.forEach(function(t){return e.unbindAttribute(t,r,!0)})):this.ATTRIBUTES.forEach(function(t){return e.unbindAttribute(t,r)})}},{key:"bindAttribute",value:function(r,e,t,a){var o=ii[r.type];if(typeof o!="number")throw new Error('Program.bind: yet unsupported attribute type "'.concat(r.type,'"'));var s=e.attributeLocations[r.name],l=e.gl;if(s!==-1){l.enableVertexAttribArray(s);var u=this.isInstanced?(a?this.ATTRIBUTES_ITEMS_COUNT:Fe(this.CONSTANT_ATTRIBUTES))*Float32Array.BYTES_PER_ELEMENT:this.ATTRIBUTES_ITEMS_COUNT*Float32Array.BYTES_PER_ELEMENT;if(l.vertexAttribPointer(s,r.size,r.type,r.normalized||!1,u,t),this.isInstanced&&a)if(l instanceof WebGL2RenderingContext)l.vertexAttribDivisor(s,1);else{var h=l.getExtension("ANGLE_instanced_arrays");h&&h.vertexAttribDivisorANGLE(s,1)}}return r.size*o}},{key:"unbindAttribute",value:function(r,e,t){var a=e.attributeLocations[r.name],o=e.gl;if(a!==-1&&(o.disableVertexAttribArray(a),this.isInstanced&&t))if(o instanceof WebGL2RenderingContext)o.vertexAttribDivisor(a,0);else{var s=o.getExtension("ANGLE_instanced_arrays");s&&s.vertexAttribDivisorANGLE(a,0)}}},{key:"reallocate",value:function(r){r!==this.capacity&&(this.capacity=r,this.verticesCount=this.VERTICES*r,this.array=new Float32Array(this.isInstanced?this.capacity*this.ATTRIBUTES_ITEMS_COUNT:this.verticesCount*this.ATTRIBUTES_ITEMS_COUNT))}},{key:"hasNothingToRender",value:function(){return this.verticesCount===0}},{key:"renderProgram",value:function(r,e){var t=e.gl,a=e.program;t.enable(t.BLEND),t.useProgram(a),this.setUniforms(r,e),this.drawWebGL(this.METHOD,e)}},{key:"render",value:function(r){this.hasNothingToRender()||(this.pickProgram&&(this.pickProgram.gl.viewport(0,0,r.width*r.pixelRatio/r.downSizingRatio,r.height*r.pixelRatio/r.downSizingRatio),this.bindProgram(this.pickProgram),this.renderProgram(S(S({},r),{},{pixelRatio:r.pixelRatio/r.downSizingRatio}),this.pickProgram),this.unbindProgram(this.pickProgram)),this.normalProgram.gl.viewport(0,0,r.width*r.pixelRatio,r.height*r.pixelRatio),this.bindProgram(this.normalProgram),this.renderProgram(r,this.normalProgram),this.unbindProgram(this.normalProgram))}},{key:"drawWebGL",value:function(r,e){var t=e.gl,a=e.frameBuffer;if(t.bindFramebuffer(t.FRAMEBUFFER,a),!this.isInstanced)t.drawArrays(r,0,this.verticesCount);else if(t instanceof WebGL2RenderingContext)t.drawArraysInstanced(r,0,this.VERTICES,this.capacity);else{var o=t.getExtension("ANGLE_instanced_arrays");o&&o.drawArraysInstancedANGLE(r,0,this.VERTICES,this.capacity)}}}])})();var ve=(function(i){function n(){return G(this,n),H(this,n,arguments)}return V(n,i),z(n,[{key:"kill",value:function(){Xt(n,"kill",this,3)([])}},{key:"process",value:function(e,t,a){var o=t*this.STRIDE;if(a.hidden){for(var s=o+this.STRIDE;o<s;o++)this.array[o]=0;return}return this.processVisibleItem(Pe(e),o,a)}}])})(st);var ce=(function(i){function n(){var r;G(this,n);for(var e=arguments.length,t=new Array(e),a=0;a<e;a++)t[a]=arguments[a];return r=H(this,n,[].concat(t)),m(r,"drawLabel",void 0),r}return V(n,i),z(n,[{key:"kill",value:function(){Xt(n,"kill",this,3)([])}},{key:"process",value:function(e,t,a,o,s){var l=t*this.STRIDE;if(s.hidden||a.hidden||o.hidden){for(var u=l+this.STRIDE;l<u;l++)this.array[l]=0;return}return this.processVisibleItem(Pe(e),l,a,o,s)}}])})(st);function Ie(i,n){return(function(){function r(e,t,a){G(this,r),m(this,"drawLabel",n),this.programs=i.map(function(o){return new o(e,t,a)})}return z(r,[{key:"reallocate",value:function(t){this.programs.forEach(function(a){return a.reallocate(t)})}},{key:"process",value:function(t,a,o,s,l){this.programs.forEach(function(u){return u.process(t,a,o,s,l)})}},{key:"render",value:function(t){this.programs.forEach(function(a){return a.render(t)})}},{key:"kill",value:function(){this.programs.forEach(function(t){return t.kill()})}}])})()}function lt(i,n,r,e,t){var a=t.edgeLabelSize,o=t.edgeLabelFont,s=t.edgeLabelWeight,l=t.edgeLabelColor.attribute?n[t.edgeLabelColor.attribute]||t.edgeLabelColor.color||"#000":t.edgeLabelColor.color,u=n.label;if(u){i.fillStyle=l,i.font="".concat(s," ").concat(a,"px ").concat(o);var h=r.size,c=e.size,f=r.x,v=r.y,T=e.x,b=e.y,R=(f+T)/2,_=(v+b)/2,g=T-f,d=b-v,E=Math.sqrt(g*g+d*d);if(!(E<h+c)){f+=g*h/E,v+=d*h/E,T-=g*c/E,b-=d*c/E,R=(f+T)/2,_=(v+b)/2,g=T-f,d=b-v,E=Math.sqrt(g*g+d*d);var P=i.measureText(u).width;if(P>E){var L="\u2026";for(u=u+L,P=i.measureText(u).width;P>E&&u.length>1;)u=u.slice(0,-2)+L,P=i.measureText(u).width;if(u.length<4)return}var C;g>0?d>0?C=Math.acos(g/E):C=Math.asin(d/E):d>0?C=Math.acos(g/E)+Math.PI:C=Math.asin(g/E)+Math.PI/2,i.save(),i.translate(R,_),i.rotate(C),i.fillText(u,-P/2,n.size/2+a),i.restore()}}}function Oe(i,n,r){if(n.label){var e=r.labelSize,t=r.labelFont,a=r.labelWeight,o=r.labelColor.attribute?n[r.labelColor.attribute]||r.labelColor.color||"#000":r.labelColor.color;i.fillStyle=o,i.font="".concat(a," ").concat(e,"px ").concat(t),i.fillText(n.label,n.x+n.size+3,n.y+e/3)}}function ut(i,n,r){var e=r.labelSize,t=r.labelFont,a=r.labelWeight;i.font="".concat(a," ").concat(e,"px ").concat(t),i.fillStyle="#FFF",i.shadowOffsetX=0,i.shadowOffsetY=0,i.shadowBlur=8,i.shadowColor="#000";var o=2;if(typeof n.label=="string"){var s=i.measureText(n.label).width,l=Math.round(s+5),u=Math.round(e+2*o),h=Math.max(n.size,e/2)+o,c=Math.asin(u/2/h),f=Math.sqrt(Math.abs(Math.pow(h,2)-Math.pow(u/2,2)));i.beginPath(),i.moveTo(n.x+f,n.y+u/2),i.lineTo(n.x+h+l,n.y+u/2),i.lineTo(n.x+h+l,n.y-u/2),i.lineTo(n.x+f,n.y-u/2),i.arc(n.x,n.y,h,c,-c),i.closePath(),i.fill()}else i.beginPath(),i.arc(n.x,n.y,n.size+o,0,Math.PI*2),i.closePath(),i.fill();i.shadowOffsetX=0,i.shadowOffsetY=0,i.shadowBlur=0,Oe(i,n,r)}var ni=`
precision highp float;

varying vec4 v_color;
varying vec2 v_diffVector;
varying float v_radius;

uniform float u_correctionRatio;

const vec4 transparent = vec4(0.0, 0.0, 0.0, 0.0);

void main(void) {
  float border = u_correctionRatio * 2.0;
  float dist = length(v_diffVector) - v_radius + border;

  // No antialiasing for picking mode:
  #ifdef PICKING_MODE
  if (dist > border)
    gl_FragColor = transparent;
  else
    gl_FragColor = v_color;

  #else
  float t = 0.0;
  if (dist > border)
    t = 1.0;
  else if (dist > 0.0)
    t = dist / border;

  gl_FragColor = mix(v_color, transparent, t);
  #endif
}
`,ai=ni,oi=`
attribute vec4 a_id;
attribute vec4 a_color;
attribute vec2 a_position;
attribute float a_size;
attribute float a_angle;

uniform mat3 u_matrix;
uniform float u_sizeRatio;
uniform float u_correctionRatio;

varying vec4 v_color;
varying vec2 v_diffVector;
varying float v_radius;
varying float v_border;

const float bias = 255.0 / 254.0;

void main() {
  float size = a_size * u_correctionRatio / u_sizeRatio * 4.0;
  vec2 diffVector = size * vec2(cos(a_angle), sin(a_angle));
  vec2 position = a_position + diffVector;
  gl_Position = vec4(
    (u_matrix * vec3(position, 1)).xy,
    0,
    1
  );

  v_diffVector = diffVector;
  v_radius = size / 2.0;

  #ifdef PICKING_MODE
  // For picking mode, we use the ID as the color:
  v_color = a_id;
  #else
  // For normal mode, we use the color:
  v_color = a_color;
  #endif

  v_color.a *= bias;
}
`,si=oi,Qt=WebGLRenderingContext,Ht=Qt.UNSIGNED_BYTE,nt=Qt.FLOAT,li=["u_sizeRatio","u_correctionRatio","u_matrix"],me=(function(i){function n(){return G(this,n),H(this,n,arguments)}return V(n,i),z(n,[{key:"getDefinition",value:function(){return{VERTICES:3,VERTEX_SHADER_SOURCE:si,FRAGMENT_SHADER_SOURCE:ai,METHOD:WebGLRenderingContext.TRIANGLES,UNIFORMS:li,ATTRIBUTES:[{name:"a_position",size:2,type:nt},{name:"a_size",size:1,type:nt},{name:"a_color",size:4,type:Ht,normalized:!0},{name:"a_id",size:4,type:Ht,normalized:!0}],CONSTANT_ATTRIBUTES:[{name:"a_angle",size:1,type:nt}],CONSTANT_DATA:[[n.ANGLE_1],[n.ANGLE_2],[n.ANGLE_3]]}}},{key:"processVisibleItem",value:function(e,t,a){var o=this.array,s=q(a.color);o[t++]=a.x,o[t++]=a.y,o[t++]=a.size,o[t++]=s,o[t++]=e}},{key:"setUniforms",value:function(e,t){var a=t.gl,o=t.uniformLocations,s=o.u_sizeRatio,l=o.u_correctionRatio,u=o.u_matrix;a.uniform1f(l,e.correctionRatio),a.uniform1f(s,e.sizeRatio),a.uniformMatrix3fv(u,!1,e.matrix)}}])})(ve);m(me,"ANGLE_1",0);m(me,"ANGLE_2",2*Math.PI/3);m(me,"ANGLE_3",4*Math.PI/3);var ui=`
precision mediump float;

varying vec4 v_color;

void main(void) {
  gl_FragColor = v_color;
}
`,hi=ui,ci=`
attribute vec2 a_position;
attribute vec2 a_normal;
attribute float a_radius;
attribute vec3 a_barycentric;

#ifdef PICKING_MODE
attribute vec4 a_id;
#else
attribute vec4 a_color;
#endif

uniform mat3 u_matrix;
uniform float u_sizeRatio;
uniform float u_correctionRatio;
uniform float u_minEdgeThickness;
uniform float u_lengthToThicknessRatio;
uniform float u_widenessToThicknessRatio;

varying vec4 v_color;

const float bias = 255.0 / 254.0;

void main() {
  float minThickness = u_minEdgeThickness;

  float normalLength = length(a_normal);
  vec2 unitNormal = a_normal / normalLength;

  // These first computations are taken from edge.vert.glsl and
  // edge.clamped.vert.glsl. Please read it to get better comments on what's
  // happening:
  float pixelsThickness = max(normalLength / u_sizeRatio, minThickness);
  float webGLThickness = pixelsThickness * u_correctionRatio;
  float webGLNodeRadius = a_radius * 2.0 * u_correctionRatio / u_sizeRatio;
  float webGLArrowHeadLength = webGLThickness * u_lengthToThicknessRatio * 2.0;
  float webGLArrowHeadThickness = webGLThickness * u_widenessToThicknessRatio;

  float da = a_barycentric.x;
  float db = a_barycentric.y;
  float dc = a_barycentric.z;

  vec2 delta = vec2(
      da * (webGLNodeRadius * unitNormal.y)
    + db * ((webGLNodeRadius + webGLArrowHeadLength) * unitNormal.y + webGLArrowHeadThickness * unitNormal.x)
    + dc * ((webGLNodeRadius + webGLArrowHeadLength) * unitNormal.y - webGLArrowHeadThickness * unitNormal.x),

      da * (-webGLNodeRadius * unitNormal.x)
    + db * (-(webGLNodeRadius + webGLArrowHeadLength) * unitNormal.x + webGLArrowHeadThickness * unitNormal.y)
    + dc * (-(webGLNodeRadius + webGLArrowHeadLength) * unitNormal.x - webGLArrowHeadThickness * unitNormal.y)
  );

  vec2 position = (u_matrix * vec3(a_position + delta, 1)).xy;

  gl_Position = vec4(position, 0, 1);

  #ifdef PICKING_MODE
  // For picking mode, we use the ID as the color:
  v_color = a_id;
  #else
  // For normal mode, we use the color:
  v_color = a_color;
  #endif

  v_color.a *= bias;
}
`,di=ci,Jt=WebGLRenderingContext,Vt=Jt.UNSIGNED_BYTE,De=Jt.FLOAT,fi=["u_matrix","u_sizeRatio","u_correctionRatio","u_minEdgeThickness","u_lengthToThicknessRatio","u_widenessToThicknessRatio"],Re={extremity:"target",lengthToThicknessRatio:2.5,widenessToThicknessRatio:2};function pe(i){var n=S(S({},Re),i||{});return(function(r){function e(){return G(this,e),H(this,e,arguments)}return V(e,r),z(e,[{key:"getDefinition",value:function(){return{VERTICES:3,VERTEX_SHADER_SOURCE:di,FRAGMENT_SHADER_SOURCE:hi,METHOD:WebGLRenderingContext.TRIANGLES,UNIFORMS:fi,ATTRIBUTES:[{name:"a_position",size:2,type:De},{name:"a_normal",size:2,type:De},{name:"a_radius",size:1,type:De},{name:"a_color",size:4,type:Vt,normalized:!0},{name:"a_id",size:4,type:Vt,normalized:!0}],CONSTANT_ATTRIBUTES:[{name:"a_barycentric",size:3,type:De}],CONSTANT_DATA:[[1,0,0],[0,1,0],[0,0,1]]}}},{key:"processVisibleItem",value:function(a,o,s,l,u){if(n.extremity==="source"){var h=[l,s];s=h[0],l=h[1]}var c=u.size||1,f=l.size||1,v=s.x,T=s.y,b=l.x,R=l.y,_=q(u.color),g=b-v,d=R-T,E=g*g+d*d,P=0,L=0;E&&(E=1/Math.sqrt(E),P=-d*E*c,L=g*E*c);var C=this.array;C[o++]=b,C[o++]=R,C[o++]=-P,C[o++]=-L,C[o++]=f,C[o++]=_,C[o++]=a}},{key:"setUniforms",value:function(a,o){var s=o.gl,l=o.uniformLocations,u=l.u_matrix,h=l.u_sizeRatio,c=l.u_correctionRatio,f=l.u_minEdgeThickness,v=l.u_lengthToThicknessRatio,T=l.u_widenessToThicknessRatio;s.uniformMatrix3fv(u,!1,a.matrix),s.uniform1f(h,a.sizeRatio),s.uniform1f(c,a.correctionRatio),s.uniform1f(f,a.minEdgeThickness),s.uniform1f(v,n.lengthToThicknessRatio),s.uniform1f(T,n.widenessToThicknessRatio)}}])})(ce)}var qn=pe();var gi=`
precision mediump float;

varying vec4 v_color;
varying vec2 v_normal;
varying float v_thickness;
varying float v_feather;

const vec4 transparent = vec4(0.0, 0.0, 0.0, 0.0);

void main(void) {
  // We only handle antialiasing for normal mode:
  #ifdef PICKING_MODE
  gl_FragColor = v_color;
  #else
  float dist = length(v_normal) * v_thickness;

  float t = smoothstep(
    v_thickness - v_feather,
    v_thickness,
    dist
  );

  gl_FragColor = mix(v_color, transparent, t);
  #endif
}
`,Ge=gi,vi=`
attribute vec4 a_id;
attribute vec4 a_color;
attribute vec2 a_normal;
attribute float a_normalCoef;
attribute vec2 a_positionStart;
attribute vec2 a_positionEnd;
attribute float a_positionCoef;
attribute float a_radius;
attribute float a_radiusCoef;

uniform mat3 u_matrix;
uniform float u_zoomRatio;
uniform float u_sizeRatio;
uniform float u_pixelRatio;
uniform float u_correctionRatio;
uniform float u_minEdgeThickness;
uniform float u_lengthToThicknessRatio;
uniform float u_feather;

varying vec4 v_color;
varying vec2 v_normal;
varying float v_thickness;
varying float v_feather;

const float bias = 255.0 / 254.0;

void main() {
  float minThickness = u_minEdgeThickness;

  float radius = a_radius * a_radiusCoef;
  vec2 normal = a_normal * a_normalCoef;
  vec2 position = a_positionStart * (1.0 - a_positionCoef) + a_positionEnd * a_positionCoef;

  float normalLength = length(normal);
  vec2 unitNormal = normal / normalLength;

  // These first computations are taken from edge.vert.glsl. Please read it to
  // get better comments on what's happening:
  float pixelsThickness = max(normalLength, minThickness * u_sizeRatio);
  float webGLThickness = pixelsThickness * u_correctionRatio / u_sizeRatio;

  // Here, we move the point to leave space for the arrow head:
  float direction = sign(radius);
  float webGLNodeRadius = direction * radius * 2.0 * u_correctionRatio / u_sizeRatio;
  float webGLArrowHeadLength = webGLThickness * u_lengthToThicknessRatio * 2.0;

  vec2 compensationVector = vec2(-direction * unitNormal.y, direction * unitNormal.x) * (webGLNodeRadius + webGLArrowHeadLength);

  // Here is the proper position of the vertex
  gl_Position = vec4((u_matrix * vec3(position + unitNormal * webGLThickness + compensationVector, 1)).xy, 0, 1);

  v_thickness = webGLThickness / u_zoomRatio;

  v_normal = unitNormal;

  v_feather = u_feather * u_correctionRatio / u_zoomRatio / u_pixelRatio * 2.0;

  #ifdef PICKING_MODE
  // For picking mode, we use the ID as the color:
  v_color = a_id;
  #else
  // For normal mode, we use the color:
  v_color = a_color;
  #endif

  v_color.a *= bias;
}
`,mi=vi,er=WebGLRenderingContext,Wt=er.UNSIGNED_BYTE,he=er.FLOAT,pi=["u_matrix","u_zoomRatio","u_sizeRatio","u_correctionRatio","u_pixelRatio","u_feather","u_minEdgeThickness","u_lengthToThicknessRatio"],tr={lengthToThicknessRatio:Re.lengthToThicknessRatio};function ht(i){var n=S(S({},tr),i||{});return(function(r){function e(){return G(this,e),H(this,e,arguments)}return V(e,r),z(e,[{key:"getDefinition",value:function(){return{VERTICES:6,VERTEX_SHADER_SOURCE:mi,FRAGMENT_SHADER_SOURCE:Ge,METHOD:WebGLRenderingContext.TRIANGLES,UNIFORMS:pi,ATTRIBUTES:[{name:"a_positionStart",size:2,type:he},{name:"a_positionEnd",size:2,type:he},{name:"a_normal",size:2,type:he},{name:"a_color",size:4,type:Wt,normalized:!0},{name:"a_id",size:4,type:Wt,normalized:!0},{name:"a_radius",size:1,type:he}],CONSTANT_ATTRIBUTES:[{name:"a_positionCoef",size:1,type:he},{name:"a_normalCoef",size:1,type:he},{name:"a_radiusCoef",size:1,type:he}],CONSTANT_DATA:[[0,1,0],[0,-1,0],[1,1,1],[1,1,1],[0,-1,0],[1,-1,-1]]}}},{key:"processVisibleItem",value:function(a,o,s,l,u){var h=u.size||1,c=s.x,f=s.y,v=l.x,T=l.y,b=q(u.color),R=v-c,_=T-f,g=l.size||1,d=R*R+_*_,E=0,P=0;d&&(d=1/Math.sqrt(d),E=-_*d*h,P=R*d*h);var L=this.array;L[o++]=c,L[o++]=f,L[o++]=v,L[o++]=T,L[o++]=E,L[o++]=P,L[o++]=b,L[o++]=a,L[o++]=g}},{key:"setUniforms",value:function(a,o){var s=o.gl,l=o.uniformLocations,u=l.u_matrix,h=l.u_zoomRatio,c=l.u_feather,f=l.u_pixelRatio,v=l.u_correctionRatio,T=l.u_sizeRatio,b=l.u_minEdgeThickness,R=l.u_lengthToThicknessRatio;s.uniformMatrix3fv(u,!1,a.matrix),s.uniform1f(h,a.zoomRatio),s.uniform1f(T,a.sizeRatio),s.uniform1f(v,a.correctionRatio),s.uniform1f(f,a.pixelRatio),s.uniform1f(c,a.antiAliasingFeather),s.uniform1f(b,a.minEdgeThickness),s.uniform1f(R,n.lengthToThicknessRatio)}}])})(ce)}var Zn=ht();function rr(i){return Ie([ht(i),pe(i)])}var bi=rr(),ct=bi,yi=`
attribute vec4 a_id;
attribute vec4 a_color;
attribute vec2 a_normal;
attribute float a_normalCoef;
attribute vec2 a_positionStart;
attribute vec2 a_positionEnd;
attribute float a_positionCoef;

uniform mat3 u_matrix;
uniform float u_sizeRatio;
uniform float u_zoomRatio;
uniform float u_pixelRatio;
uniform float u_correctionRatio;
uniform float u_minEdgeThickness;
uniform float u_feather;

varying vec4 v_color;
varying vec2 v_normal;
varying float v_thickness;
varying float v_feather;

const float bias = 255.0 / 254.0;

void main() {
  float minThickness = u_minEdgeThickness;

  vec2 normal = a_normal * a_normalCoef;
  vec2 position = a_positionStart * (1.0 - a_positionCoef) + a_positionEnd * a_positionCoef;

  float normalLength = length(normal);
  vec2 unitNormal = normal / normalLength;

  // We require edges to be at least "minThickness" pixels thick *on screen*
  // (so we need to compensate the size ratio):
  float pixelsThickness = max(normalLength, minThickness * u_sizeRatio);

  // Then, we need to retrieve the normalized thickness of the edge in the WebGL
  // referential (in a ([0, 1], [0, 1]) space), using our "magic" correction
  // ratio:
  float webGLThickness = pixelsThickness * u_correctionRatio / u_sizeRatio;

  // Here is the proper position of the vertex
  gl_Position = vec4((u_matrix * vec3(position + unitNormal * webGLThickness, 1)).xy, 0, 1);

  // For the fragment shader though, we need a thickness that takes the "magic"
  // correction ratio into account (as in webGLThickness), but so that the
  // antialiasing effect does not depend on the zoom level. So here's yet
  // another thickness version:
  v_thickness = webGLThickness / u_zoomRatio;

  v_normal = unitNormal;

  v_feather = u_feather * u_correctionRatio / u_zoomRatio / u_pixelRatio * 2.0;

  #ifdef PICKING_MODE
  // For picking mode, we use the ID as the color:
  v_color = a_id;
  #else
  // For normal mode, we use the color:
  v_color = a_color;
  #endif

  v_color.a *= bias;
}
`,Ei=yi,ir=WebGLRenderingContext,jt=ir.UNSIGNED_BYTE,Te=ir.FLOAT,_i=["u_matrix","u_zoomRatio","u_sizeRatio","u_correctionRatio","u_pixelRatio","u_feather","u_minEdgeThickness"],dt=(function(i){function n(){return G(this,n),H(this,n,arguments)}return V(n,i),z(n,[{key:"getDefinition",value:function(){return{VERTICES:6,VERTEX_SHADER_SOURCE:Ei,FRAGMENT_SHADER_SOURCE:Ge,METHOD:WebGLRenderingContext.TRIANGLES,UNIFORMS:_i,ATTRIBUTES:[{name:"a_positionStart",size:2,type:Te},{name:"a_positionEnd",size:2,type:Te},{name:"a_normal",size:2,type:Te},{name:"a_color",size:4,type:jt,normalized:!0},{name:"a_id",size:4,type:jt,normalized:!0}],CONSTANT_ATTRIBUTES:[{name:"a_positionCoef",size:1,type:Te},{name:"a_normalCoef",size:1,type:Te}],CONSTANT_DATA:[[0,1],[0,-1],[1,1],[1,1],[0,-1],[1,-1]]}}},{key:"processVisibleItem",value:function(e,t,a,o,s){var l=s.size||1,u=a.x,h=a.y,c=o.x,f=o.y,v=q(s.color),T=c-u,b=f-h,R=T*T+b*b,_=0,g=0;R&&(R=1/Math.sqrt(R),_=-b*R*l,g=T*R*l);var d=this.array;d[t++]=u,d[t++]=h,d[t++]=c,d[t++]=f,d[t++]=_,d[t++]=g,d[t++]=v,d[t++]=e}},{key:"setUniforms",value:function(e,t){var a=t.gl,o=t.uniformLocations,s=o.u_matrix,l=o.u_zoomRatio,u=o.u_feather,h=o.u_pixelRatio,c=o.u_correctionRatio,f=o.u_sizeRatio,v=o.u_minEdgeThickness;a.uniformMatrix3fv(s,!1,e.matrix),a.uniform1f(l,e.zoomRatio),a.uniform1f(f,e.sizeRatio),a.uniform1f(c,e.correctionRatio),a.uniform1f(h,e.pixelRatio),a.uniform1f(u,e.antiAliasingFeather),a.uniform1f(v,e.minEdgeThickness)}}])})(ce);var nr=fe(Ke()),ze=(function(i){function n(){var r;return G(this,n),r=H(this,n),r.rawEmitter=r,r}return V(n,i),z(n)})(nr.EventEmitter);var sr=fe(Qe());var Ti=function(n){return n},Ri=function(n){return n*n},xi=function(n){return n*(2-n)},Ci=function(n){return(n*=2)<1?.5*n*n:-.5*(--n*(n-2)-1)},Si=function(n){return n*n*n},wi=function(n){return--n*n*n+1},Ai=function(n){return(n*=2)<1?.5*n*n*n:.5*((n-=2)*n*n+2)},lr={linear:Ti,quadraticIn:Ri,quadraticOut:xi,quadraticInOut:Ci,cubicIn:Si,cubicOut:wi,cubicInOut:Ai},ur={easing:"quadraticInOut",duration:150};function $(){return Float32Array.of(1,0,0,0,1,0,0,0,1)}function Me(i,n,r){return i[0]=n,i[4]=typeof r=="number"?r:n,i}function ar(i,n){var r=Math.sin(n),e=Math.cos(n);return i[0]=e,i[1]=r,i[3]=-r,i[4]=e,i}function or(i,n,r){return i[6]=n,i[7]=r,i}function oe(i,n){var r=i[0],e=i[1],t=i[2],a=i[3],o=i[4],s=i[5],l=i[6],u=i[7],h=i[8],c=n[0],f=n[1],v=n[2],T=n[3],b=n[4],R=n[5],_=n[6],g=n[7],d=n[8];return i[0]=c*r+f*a+v*l,i[1]=c*e+f*o+v*u,i[2]=c*t+f*s+v*h,i[3]=T*r+b*a+R*l,i[4]=T*e+b*o+R*u,i[5]=T*t+b*s+R*h,i[6]=_*r+g*a+d*l,i[7]=_*e+g*o+d*u,i[8]=_*t+g*s+d*h,i}function Ue(i,n){var r=arguments.length>2&&arguments[2]!==void 0?arguments[2]:1,e=i[0],t=i[1],a=i[3],o=i[4],s=i[6],l=i[7],u=n.x,h=n.y;return{x:u*e+h*a+s*r,y:u*t+h*o+l*r}}function Li(i,n){var r=i.height/i.width,e=n.height/n.width;return r<1&&e>1||r>1&&e<1?1:Math.min(Math.max(e,1/e),Math.max(1/r,r))}function be(i,n,r,e,t){var a=i.angle,o=i.ratio,s=i.x,l=i.y,u=n.width,h=n.height,c=$(),f=Math.min(u,h)-2*e,v=Li(n,r);return t?(oe(c,or($(),s,l)),oe(c,Me($(),o)),oe(c,ar($(),a)),oe(c,Me($(),u/f/2/v,h/f/2/v))):(oe(c,Me($(),2*(f/u)*v,2*(f/h)*v)),oe(c,ar($(),-a)),oe(c,Me($(),1/o)),oe(c,or($(),-s,-l))),c}function hr(i,n,r){var e=Ue(i,{x:Math.cos(n.angle),y:Math.sin(n.angle)},0),t=e.x,a=e.y;return 1/Math.sqrt(Math.pow(t,2)+Math.pow(a,2))/r.width}function cr(i){if(!i.order)return{x:[0,1],y:[0,1]};var n=1/0,r=-1/0,e=1/0,t=-1/0;return i.forEachNode(function(a,o){var s=o.x,l=o.y;s<n&&(n=s),s>r&&(r=s),l<e&&(e=l),l>t&&(t=l)}),{x:[n,r],y:[e,t]}}function dr(i){if(!(0,sr.default)(i))throw new Error("Sigma: invalid graph instance.");i.forEachNode(function(n,r){if(!Number.isFinite(r.x)||!Number.isFinite(r.y))throw new Error("Sigma: Coordinates of node ".concat(n," are invalid. A node must have a numeric 'x' and 'y' attribute."))})}function fr(i,n,r){var e=document.createElement(i);if(n)for(var t in n)e.style[t]=n[t];if(r)for(var a in r)e.setAttribute(a,r[a]);return e}function ft(){return typeof window.devicePixelRatio<"u"?window.devicePixelRatio:1}function gt(i,n,r){return r.sort(function(e,t){var a=n(e)||0,o=n(t)||0;return a<o?-1:a>o?1:0})}function vt(i){var n=ae(i.x,2),r=n[0],e=n[1],t=ae(i.y,2),a=t[0],o=t[1],s=Math.max(e-r,o-a),l=(e+r)/2,u=(o+a)/2;(s===0||Math.abs(s)===1/0||isNaN(s))&&(s=1),isNaN(l)&&(l=0),isNaN(u)&&(u=0);var h=function(f){return{x:.5+(f.x-l)/s,y:.5+(f.y-u)/s}};return h.applyTo=function(c){c.x=.5+(c.x-l)/s,c.y=.5+(c.y-u)/s},h.inverse=function(c){return{x:l+s*(c.x-.5),y:u+s*(c.y-.5)}},h.ratio=s,h}function Be(i){"@babel/helpers - typeof";return Be=typeof Symbol=="function"&&typeof Symbol.iterator=="symbol"?function(n){return typeof n}:function(n){return n&&typeof Symbol=="function"&&n.constructor===Symbol&&n!==Symbol.prototype?"symbol":typeof n},Be(i)}function mt(i,n){var r=n.size;if(r!==0){var e=i.length;i.length+=r;var t=0;n.forEach(function(a){i[e+t]=a,t++})}}function He(i){i=i||{};for(var n=0,r=arguments.length<=1?0:arguments.length-1;n<r;n++){var e=n+1<1||arguments.length<=n+1?void 0:arguments[n+1];e&&Object.assign(i,e)}return i}var Ve={hideEdgesOnMove:!1,hideLabelsOnMove:!1,renderLabels:!0,renderEdgeLabels:!1,enableEdgeEvents:!1,defaultNodeColor:"#999",defaultNodeType:"circle",defaultEdgeColor:"#ccc",defaultEdgeType:"line",labelFont:"Arial",labelSize:14,labelWeight:"normal",labelColor:{color:"#000"},edgeLabelFont:"Arial",edgeLabelSize:14,edgeLabelWeight:"normal",edgeLabelColor:{attribute:"color"},stagePadding:30,defaultDrawEdgeLabel:lt,defaultDrawNodeLabel:Oe,defaultDrawNodeHover:ut,minEdgeThickness:1.7,antiAliasingFeather:1,dragTimeout:100,draggedEventsTolerance:3,inertiaDuration:200,inertiaRatio:3,zoomDuration:250,zoomingRatio:1.7,doubleClickTimeout:300,doubleClickZoomingRatio:2.2,doubleClickZoomingDuration:200,tapMoveTolerance:10,zoomToSizeRatioFunction:Math.sqrt,itemSizesReference:"screen",autoRescale:!0,autoCenter:!0,labelDensity:1,labelGridCellSize:100,labelRenderedSizeThreshold:6,nodeReducer:null,edgeReducer:null,zIndex:!1,minCameraRatio:null,maxCameraRatio:null,enableCameraZooming:!0,enableCameraPanning:!0,enableCameraRotation:!0,cameraPanBoundaries:null,allowInvalidContainer:!1,nodeProgramClasses:{},nodeHoverProgramClasses:{},edgeProgramClasses:{}},Pi={circle:me},ki={arrow:ct,line:dt};function We(i){if(typeof i.labelDensity!="number"||i.labelDensity<0)throw new Error("Settings: invalid `labelDensity`. Expecting a positive number.");var n=i.minCameraRatio,r=i.maxCameraRatio;if(typeof n=="number"&&typeof r=="number"&&r<n)throw new Error("Settings: invalid camera ratio boundaries. Expecting `maxCameraRatio` to be greater than `minCameraRatio`.")}function gr(i){var n=He({},Ve,i);return n.nodeProgramClasses=He({},Pi,n.nodeProgramClasses),n.edgeProgramClasses=He({},ki,n.edgeProgramClasses),n}var da=fe(Ke()),fa=fe(Qe()),je=1.5,vr=(function(i){function n(){var r;return G(this,n),r=H(this,n),m(r,"x",.5),m(r,"y",.5),m(r,"angle",0),m(r,"ratio",1),m(r,"minRatio",null),m(r,"maxRatio",null),m(r,"enabledZooming",!0),m(r,"enabledPanning",!0),m(r,"enabledRotation",!0),m(r,"clean",null),m(r,"nextFrame",null),m(r,"previousState",null),m(r,"enabled",!0),r.previousState=r.getState(),r}return V(n,i),z(n,[{key:"enable",value:function(){return this.enabled=!0,this}},{key:"disable",value:function(){return this.enabled=!1,this}},{key:"getState",value:function(){return{x:this.x,y:this.y,angle:this.angle,ratio:this.ratio}}},{key:"hasState",value:function(e){return this.x===e.x&&this.y===e.y&&this.ratio===e.ratio&&this.angle===e.angle}},{key:"getPreviousState",value:function(){var e=this.previousState;return e?{x:e.x,y:e.y,angle:e.angle,ratio:e.ratio}:null}},{key:"getBoundedRatio",value:function(e){var t=e;return typeof this.minRatio=="number"&&(t=Math.max(t,this.minRatio)),typeof this.maxRatio=="number"&&(t=Math.min(t,this.maxRatio)),t}},{key:"validateState",value:function(e){var t={};return this.enabledPanning&&typeof e.x=="number"&&(t.x=e.x),this.enabledPanning&&typeof e.y=="number"&&(t.y=e.y),this.enabledZooming&&typeof e.ratio=="number"&&(t.ratio=this.getBoundedRatio(e.ratio)),this.enabledRotation&&typeof e.angle=="number"&&(t.angle=e.angle),this.clean?this.clean(S(S({},this.getState()),t)):t}},{key:"isAnimated",value:function(){return!!this.nextFrame}},{key:"setState",value:function(e){if(!this.enabled)return this;this.previousState=this.getState();var t=this.validateState(e);return typeof t.x=="number"&&(this.x=t.x),typeof t.y=="number"&&(this.y=t.y),typeof t.ratio=="number"&&(this.ratio=t.ratio),typeof t.angle=="number"&&(this.angle=t.angle),this.hasState(this.previousState)||this.emit("updated",this.getState()),this}},{key:"updateState",value:function(e){return this.setState(e(this.getState())),this}},{key:"animate",value:function(e){var t=this,a=arguments.length>1&&arguments[1]!==void 0?arguments[1]:{},o=arguments.length>2?arguments[2]:void 0;if(!o)return new Promise(function(v){return t.animate(e,a,v)});if(this.enabled){var s=S(S({},ur),a),l=this.validateState(e),u=typeof s.easing=="function"?s.easing:lr[s.easing],h=Date.now(),c=this.getState(),f=function(){var T=(Date.now()-h)/s.duration;if(T>=1){t.nextFrame=null,t.setState(l),t.animationCallback&&(t.animationCallback.call(null),t.animationCallback=void 0);return}var b=u(T),R={};typeof l.x=="number"&&(R.x=c.x+(l.x-c.x)*b),typeof l.y=="number"&&(R.y=c.y+(l.y-c.y)*b),t.enabledRotation&&typeof l.angle=="number"&&(R.angle=c.angle+(l.angle-c.angle)*b),typeof l.ratio=="number"&&(R.ratio=c.ratio+(l.ratio-c.ratio)*b),t.setState(R),t.nextFrame=requestAnimationFrame(f)};this.nextFrame?(cancelAnimationFrame(this.nextFrame),this.animationCallback&&this.animationCallback.call(null),this.nextFrame=requestAnimationFrame(f)):f(),this.animationCallback=o}}},{key:"animatedZoom",value:function(e){return e?typeof e=="number"?this.animate({ratio:this.ratio/e}):this.animate({ratio:this.ratio/(e.factor||je)},e):this.animate({ratio:this.ratio/je})}},{key:"animatedUnzoom",value:function(e){return e?typeof e=="number"?this.animate({ratio:this.ratio*e}):this.animate({ratio:this.ratio*(e.factor||je)},e):this.animate({ratio:this.ratio*je})}},{key:"animatedReset",value:function(e){return this.animate({x:.5,y:.5,ratio:1,angle:0},e)}},{key:"copy",value:function(){return n.from(this.getState())}}],[{key:"from",value:function(e){var t=new n;return t.setState(e)}}])})(ze);function K(i,n){var r=n.getBoundingClientRect();return{x:i.clientX-r.left,y:i.clientY-r.top}}function ee(i,n){var r=S(S({},K(i,n)),{},{sigmaDefaultPrevented:!1,preventSigmaDefault:function(){r.sigmaDefaultPrevented=!0},original:i});return r}function xe(i){var n="x"in i?i:S(S({},i.touches[0]||i.previousTouches[0]),{},{original:i.original,sigmaDefaultPrevented:i.sigmaDefaultPrevented,preventSigmaDefault:function(){i.sigmaDefaultPrevented=!0,n.sigmaDefaultPrevented=!0}});return n}function Ni(i,n){return S(S({},ee(i,n)),{},{delta:_r(i)})}var Di=2;function Xe(i){for(var n=[],r=0,e=Math.min(i.length,Di);r<e;r++)n.push(i[r]);return n}function Ce(i,n,r){var e={touches:Xe(i.touches).map(function(t){return K(t,r)}),previousTouches:n.map(function(t){return K(t,r)}),sigmaDefaultPrevented:!1,preventSigmaDefault:function(){e.sigmaDefaultPrevented=!0},original:i};return e}function _r(i){if(typeof i.deltaY<"u")return i.deltaY*-3/360;if(typeof i.detail<"u")return i.detail/-9;throw new Error("Captor: could not extract delta from event.")}var Tr=(function(i){function n(r,e){var t;return G(this,n),t=H(this,n),t.container=r,t.renderer=e,t}return V(n,i),z(n)})(ze),Fi=["doubleClickTimeout","doubleClickZoomingDuration","doubleClickZoomingRatio","dragTimeout","draggedEventsTolerance","inertiaDuration","inertiaRatio","zoomDuration","zoomingRatio"],Ii=Fi.reduce(function(i,n){return S(S({},i),{},m({},n,Ve[n]))},{}),Oi=(function(i){function n(r,e){var t;return G(this,n),t=H(this,n,[r,e]),m(t,"enabled",!0),m(t,"draggedEvents",0),m(t,"downStartTime",null),m(t,"lastMouseX",null),m(t,"lastMouseY",null),m(t,"isMouseDown",!1),m(t,"isMoving",!1),m(t,"movingTimeout",null),m(t,"startCameraState",null),m(t,"clicks",0),m(t,"doubleClickTimeout",null),m(t,"currentWheelDirection",0),m(t,"settings",Ii),t.handleClick=t.handleClick.bind(t),t.handleRightClick=t.handleRightClick.bind(t),t.handleDown=t.handleDown.bind(t),t.handleUp=t.handleUp.bind(t),t.handleMove=t.handleMove.bind(t),t.handleWheel=t.handleWheel.bind(t),t.handleLeave=t.handleLeave.bind(t),t.handleEnter=t.handleEnter.bind(t),r.addEventListener("click",t.handleClick,{capture:!1}),r.addEventListener("contextmenu",t.handleRightClick,{capture:!1}),r.addEventListener("mousedown",t.handleDown,{capture:!1}),r.addEventListener("wheel",t.handleWheel,{capture:!1}),r.addEventListener("mouseleave",t.handleLeave,{capture:!1}),r.addEventListener("mouseenter",t.handleEnter,{capture:!1}),document.addEventListener("mousemove",t.handleMove,{capture:!1}),document.addEventListener("mouseup",t.handleUp,{capture:!1}),t}return V(n,i),z(n,[{key:"kill",value:function(){var e=this.container;e.removeEventListener("click",this.handleClick),e.removeEventListener("contextmenu",this.handleRightClick),e.removeEventListener("mousedown",this.handleDown),e.removeEventListener("wheel",this.handleWheel),e.removeEventListener("mouseleave",this.handleLeave),e.removeEventListener("mouseenter",this.handleEnter),document.removeEventListener("mousemove",this.handleMove),document.removeEventListener("mouseup",this.handleUp)}},{key:"handleClick",value:function(e){var t=this;if(this.enabled){if(this.clicks++,this.clicks===2)return this.clicks=0,typeof this.doubleClickTimeout=="number"&&(clearTimeout(this.doubleClickTimeout),this.doubleClickTimeout=null),this.handleDoubleClick(e);setTimeout(function(){t.clicks=0,t.doubleClickTimeout=null},this.settings.doubleClickTimeout),this.draggedEvents<this.settings.draggedEventsTolerance&&this.emit("click",ee(e,this.container))}}},{key:"handleRightClick",value:function(e){this.enabled&&this.emit("rightClick",ee(e,this.container))}},{key:"handleDoubleClick",value:function(e){if(this.enabled){e.preventDefault(),e.stopPropagation();var t=ee(e,this.container);if(this.emit("doubleClick",t),!t.sigmaDefaultPrevented){var a=this.renderer.getCamera(),o=a.getBoundedRatio(a.getState().ratio/this.settings.doubleClickZoomingRatio);a.animate(this.renderer.getViewportZoomedState(K(e,this.container),o),{easing:"quadraticInOut",duration:this.settings.doubleClickZoomingDuration})}}}},{key:"handleDown",value:function(e){if(this.enabled){if(e.button===0){this.startCameraState=this.renderer.getCamera().getState();var t=K(e,this.container),a=t.x,o=t.y;this.lastMouseX=a,this.lastMouseY=o,this.draggedEvents=0,this.downStartTime=Date.now(),this.isMouseDown=!0}this.emit("mousedown",ee(e,this.container))}}},{key:"handleUp",value:function(e){var t=this;if(!(!this.enabled||!this.isMouseDown)){var a=this.renderer.getCamera();this.isMouseDown=!1,typeof this.movingTimeout=="number"&&(clearTimeout(this.movingTimeout),this.movingTimeout=null);var o=K(e,this.container),s=o.x,l=o.y,u=a.getState(),h=a.getPreviousState()||{x:0,y:0};this.isMoving?a.animate({x:u.x+this.settings.inertiaRatio*(u.x-h.x),y:u.y+this.settings.inertiaRatio*(u.y-h.y)},{duration:this.settings.inertiaDuration,easing:"quadraticOut"}):(this.lastMouseX!==s||this.lastMouseY!==l)&&a.setState({x:u.x,y:u.y}),this.isMoving=!1,setTimeout(function(){var c=t.draggedEvents>0;t.draggedEvents=0,c&&t.renderer.getSetting("hideEdgesOnMove")&&t.renderer.refresh()},0),this.emit("mouseup",ee(e,this.container))}}},{key:"handleMove",value:function(e){var t=this;if(this.enabled){var a=ee(e,this.container);if(this.emit("mousemovebody",a),(e.target===this.container||e.composedPath()[0]===this.container)&&this.emit("mousemove",a),!a.sigmaDefaultPrevented&&this.isMouseDown){this.isMoving=!0,this.draggedEvents++,typeof this.movingTimeout=="number"&&clearTimeout(this.movingTimeout),this.movingTimeout=window.setTimeout(function(){t.movingTimeout=null,t.isMoving=!1},this.settings.dragTimeout);var o=this.renderer.getCamera(),s=K(e,this.container),l=s.x,u=s.y,h=this.renderer.viewportToFramedGraph({x:this.lastMouseX,y:this.lastMouseY}),c=this.renderer.viewportToFramedGraph({x:l,y:u}),f=h.x-c.x,v=h.y-c.y,T=o.getState(),b=T.x+f,R=T.y+v;o.setState({x:b,y:R}),this.lastMouseX=l,this.lastMouseY=u,e.preventDefault(),e.stopPropagation()}}}},{key:"handleLeave",value:function(e){this.emit("mouseleave",ee(e,this.container))}},{key:"handleEnter",value:function(e){this.emit("mouseenter",ee(e,this.container))}},{key:"handleWheel",value:function(e){var t=this,a=this.renderer.getCamera();if(!(!this.enabled||!a.enabledZooming)){var o=_r(e);if(o){var s=Ni(e,this.container);if(this.emit("wheel",s),s.sigmaDefaultPrevented){e.preventDefault(),e.stopPropagation();return}var l=a.getState().ratio,u=o>0?1/this.settings.zoomingRatio:this.settings.zoomingRatio,h=a.getBoundedRatio(l*u),c=o>0?1:-1,f=Date.now();l!==h&&(e.preventDefault(),e.stopPropagation(),!(this.currentWheelDirection===c&&this.lastWheelTriggerTime&&f-this.lastWheelTriggerTime<this.settings.zoomDuration/5)&&(a.animate(this.renderer.getViewportZoomedState(K(e,this.container),h),{easing:"quadraticOut",duration:this.settings.zoomDuration},function(){t.currentWheelDirection=0}),this.currentWheelDirection=c,this.lastWheelTriggerTime=f))}}}},{key:"setSettings",value:function(e){this.settings=e}}])})(Tr),Gi=["dragTimeout","inertiaDuration","inertiaRatio","doubleClickTimeout","doubleClickZoomingRatio","doubleClickZoomingDuration","tapMoveTolerance"],zi=Gi.reduce(function(i,n){return S(S({},i),{},m({},n,Ve[n]))},{}),Mi=(function(i){function n(r,e){var t;return G(this,n),t=H(this,n,[r,e]),m(t,"enabled",!0),m(t,"isMoving",!1),m(t,"hasMoved",!1),m(t,"touchMode",0),m(t,"startTouchesPositions",[]),m(t,"lastTouches",[]),m(t,"lastTap",null),m(t,"settings",zi),t.handleStart=t.handleStart.bind(t),t.handleLeave=t.handleLeave.bind(t),t.handleMove=t.handleMove.bind(t),r.addEventListener("touchstart",t.handleStart,{capture:!1}),r.addEventListener("touchcancel",t.handleLeave,{capture:!1}),document.addEventListener("touchend",t.handleLeave,{capture:!1,passive:!1}),document.addEventListener("touchmove",t.handleMove,{capture:!1,passive:!1}),t}return V(n,i),z(n,[{key:"kill",value:function(){var e=this.container;e.removeEventListener("touchstart",this.handleStart),e.removeEventListener("touchcancel",this.handleLeave),document.removeEventListener("touchend",this.handleLeave),document.removeEventListener("touchmove",this.handleMove)}},{key:"getDimensions",value:function(){return{width:this.container.offsetWidth,height:this.container.offsetHeight}}},{key:"handleStart",value:function(e){var t=this;if(this.enabled){e.preventDefault();var a=Xe(e.touches);if(this.touchMode=a.length,this.startCameraState=this.renderer.getCamera().getState(),this.startTouchesPositions=a.map(function(v){return K(v,t.container)}),this.touchMode===2){var o=ae(this.startTouchesPositions,2),s=o[0],l=s.x,u=s.y,h=o[1],c=h.x,f=h.y;this.startTouchesAngle=Math.atan2(f-u,c-l),this.startTouchesDistance=Math.sqrt(Math.pow(c-l,2)+Math.pow(f-u,2))}this.emit("touchdown",Ce(e,this.lastTouches,this.container)),this.lastTouches=a,this.lastTouchesPositions=this.startTouchesPositions}}},{key:"handleLeave",value:function(e){if(!(!this.enabled||!this.startTouchesPositions.length)){switch(e.cancelable&&e.preventDefault(),this.movingTimeout&&(this.isMoving=!1,clearTimeout(this.movingTimeout)),this.touchMode){case 2:if(e.touches.length===1){this.handleStart(e),e.preventDefault();break}case 1:if(this.isMoving){var t=this.renderer.getCamera(),a=t.getState(),o=t.getPreviousState()||{x:0,y:0};t.animate({x:a.x+this.settings.inertiaRatio*(a.x-o.x),y:a.y+this.settings.inertiaRatio*(a.y-o.y)},{duration:this.settings.inertiaDuration,easing:"quadraticOut"})}this.hasMoved=!1,this.isMoving=!1,this.touchMode=0;break}if(this.emit("touchup",Ce(e,this.lastTouches,this.container)),!e.touches.length){var s=K(this.lastTouches[0],this.container),l=this.startTouchesPositions[0],u=Math.pow(s.x-l.x,2)+Math.pow(s.y-l.y,2);if(!e.touches.length&&u<Math.pow(this.settings.tapMoveTolerance,2))if(this.lastTap&&Date.now()-this.lastTap.time<this.settings.doubleClickTimeout){var h=Ce(e,this.lastTouches,this.container);if(this.emit("doubletap",h),this.lastTap=null,!h.sigmaDefaultPrevented){var c=this.renderer.getCamera(),f=c.getBoundedRatio(c.getState().ratio/this.settings.doubleClickZoomingRatio);c.animate(this.renderer.getViewportZoomedState(s,f),{easing:"quadraticInOut",duration:this.settings.doubleClickZoomingDuration})}}else{var v=Ce(e,this.lastTouches,this.container);this.emit("tap",v),this.lastTap={time:Date.now(),position:v.touches[0]||v.previousTouches[0]}}}this.lastTouches=Xe(e.touches),this.startTouchesPositions=[]}}},{key:"handleMove",value:function(e){var t=this;if(!(!this.enabled||!this.startTouchesPositions.length)){e.preventDefault();var a=Xe(e.touches),o=a.map(function(k){return K(k,t.container)}),s=this.lastTouches;this.lastTouches=a,this.lastTouchesPositions=o;var l=Ce(e,s,this.container);if(this.emit("touchmove",l),!l.sigmaDefaultPrevented&&(this.hasMoved||(this.hasMoved=o.some(function(k,O){var F=t.startTouchesPositions[O];return F&&(k.x!==F.x||k.y!==F.y)})),!!this.hasMoved)){this.isMoving=!0,this.movingTimeout&&clearTimeout(this.movingTimeout),this.movingTimeout=window.setTimeout(function(){t.isMoving=!1},this.settings.dragTimeout);var u=this.renderer.getCamera(),h=this.startCameraState,c=this.renderer.getSetting("stagePadding");switch(this.touchMode){case 1:{var f=this.renderer.viewportToFramedGraph((this.startTouchesPositions||[])[0]),v=f.x,T=f.y,b=this.renderer.viewportToFramedGraph(o[0]),R=b.x,_=b.y;u.setState({x:h.x+v-R,y:h.y+T-_});break}case 2:{var g={x:.5,y:.5,angle:0,ratio:1},d=o[0],E=d.x,P=d.y,L=o[1],C=L.x,I=L.y,D=Math.atan2(I-P,C-E)-this.startTouchesAngle,N=Math.hypot(I-P,C-E)/this.startTouchesDistance,B=u.getBoundedRatio(h.ratio/N);g.ratio=B,g.angle=h.angle+D;var U=this.getDimensions(),Y=this.renderer.viewportToFramedGraph((this.startTouchesPositions||[])[0],{cameraState:h}),M=Math.min(U.width,U.height)-2*c,W=M/U.width,p=M/U.height,y=B/M,x=E-M/2/W,A=P-M/2/p,w=[x*Math.cos(-g.angle)-A*Math.sin(-g.angle),A*Math.cos(-g.angle)+x*Math.sin(-g.angle)];x=w[0],A=w[1],g.x=Y.x-x*y,g.y=Y.y+A*y,u.setState(g);break}}}}}},{key:"setSettings",value:function(e){this.settings=e}}])})(Tr);function Ui(i){if(Array.isArray(i))return Le(i)}function Bi(i){if(typeof Symbol<"u"&&i[Symbol.iterator]!=null||i["@@iterator"]!=null)return Array.from(i)}function Hi(){throw new TypeError(`Invalid attempt to spread non-iterable instance.
In order to be iterable, non-array objects must have a [Symbol.iterator]() method.`)}function mr(i){return Ui(i)||Bi(i)||rt(i)||Hi()}function Vi(i,n){if(i==null)return{};var r={};for(var e in i)if({}.hasOwnProperty.call(i,e)){if(n.indexOf(e)!==-1)continue;r[e]=i[e]}return r}function pt(i,n){if(i==null)return{};var r,e,t=Vi(i,n);if(Object.getOwnPropertySymbols){var a=Object.getOwnPropertySymbols(i);for(e=0;e<a.length;e++)r=a[e],n.indexOf(r)===-1&&{}.propertyIsEnumerable.call(i,r)&&(t[r]=i[r])}return t}var pr=(function(){function i(n,r){G(this,i),this.key=n,this.size=r}return z(i,null,[{key:"compare",value:function(r,e){return r.size>e.size?-1:r.size<e.size||r.key>e.key?1:-1}}])})(),br=(function(){function i(){G(this,i),m(this,"width",0),m(this,"height",0),m(this,"cellSize",0),m(this,"columns",0),m(this,"rows",0),m(this,"cells",{})}return z(i,[{key:"resizeAndClear",value:function(r,e){this.width=r.width,this.height=r.height,this.cellSize=e,this.columns=Math.ceil(r.width/e),this.rows=Math.ceil(r.height/e),this.cells={}}},{key:"getIndex",value:function(r){var e=Math.floor(r.x/this.cellSize),t=Math.floor(r.y/this.cellSize);return t*this.columns+e}},{key:"add",value:function(r,e,t){var a=new pr(r,e),o=this.getIndex(t),s=this.cells[o];s||(s=[],this.cells[o]=s),s.push(a)}},{key:"organize",value:function(){for(var r in this.cells){var e=this.cells[r];e.sort(pr.compare)}}},{key:"getLabelsToDisplay",value:function(r,e){var t=this.cellSize*this.cellSize,a=t/r/r,o=a*e/t,s=Math.ceil(o),l=[];for(var u in this.cells)for(var h=this.cells[u],c=0;c<Math.min(s,h.length);c++)l.push(h[c].key);return l}}])})();function Wi(i){var n=i.graph,r=i.hoveredNode,e=i.highlightedNodes,t=i.displayedNodeLabels,a=[];return n.forEachEdge(function(o,s,l,u){(l===r||u===r||e.has(l)||e.has(u)||t.has(l)&&t.has(u))&&a.push(o)}),a}var yr=150,Er=50,te=Object.prototype.hasOwnProperty;function ji(i,n,r){if(!te.call(r,"x")||!te.call(r,"y"))throw new Error('Sigma: could not find a valid position (x, y) for node "'.concat(n,'". All your nodes must have a number "x" and "y". Maybe your forgot to apply a layout or your "nodeReducer" is not returning the correct data?'));return r.color||(r.color=i.defaultNodeColor),!r.label&&r.label!==""&&(r.label=null),r.label!==void 0&&r.label!==null?r.label=""+r.label:r.label=null,r.size||(r.size=2),te.call(r,"hidden")||(r.hidden=!1),te.call(r,"highlighted")||(r.highlighted=!1),te.call(r,"forceLabel")||(r.forceLabel=!1),(!r.type||r.type==="")&&(r.type=i.defaultNodeType),r.zIndex||(r.zIndex=0),r}function Xi(i,n,r){return r.color||(r.color=i.defaultEdgeColor),r.label||(r.label=""),r.size||(r.size=.5),te.call(r,"hidden")||(r.hidden=!1),te.call(r,"forceLabel")||(r.forceLabel=!1),(!r.type||r.type==="")&&(r.type=i.defaultEdgeType),r.zIndex||(r.zIndex=0),r}var Yi=(function(i){function n(r,e){var t,a=arguments.length>2&&arguments[2]!==void 0?arguments[2]:{};if(G(this,n),t=H(this,n),m(t,"elements",{}),m(t,"canvasContexts",{}),m(t,"webGLContexts",{}),m(t,"pickingLayers",new Set),m(t,"textures",{}),m(t,"frameBuffers",{}),m(t,"activeListeners",{}),m(t,"labelGrid",new br),m(t,"nodeDataCache",{}),m(t,"edgeDataCache",{}),m(t,"nodeProgramIndex",{}),m(t,"edgeProgramIndex",{}),m(t,"nodesWithForcedLabels",new Set),m(t,"edgesWithForcedLabels",new Set),m(t,"nodeExtent",{x:[0,1],y:[0,1]}),m(t,"nodeZExtent",[1/0,-1/0]),m(t,"edgeZExtent",[1/0,-1/0]),m(t,"matrix",$()),m(t,"invMatrix",$()),m(t,"correctionRatio",1),m(t,"customBBox",null),m(t,"normalizationFunction",vt({x:[0,1],y:[0,1]})),m(t,"graphToViewportRatio",1),m(t,"itemIDsIndex",{}),m(t,"nodeIndices",{}),m(t,"edgeIndices",{}),m(t,"width",0),m(t,"height",0),m(t,"pixelRatio",ft()),m(t,"pickingDownSizingRatio",2*t.pixelRatio),m(t,"displayedNodeLabels",new Set),m(t,"displayedEdgeLabels",new Set),m(t,"highlightedNodes",new Set),m(t,"hoveredNode",null),m(t,"hoveredEdge",null),m(t,"renderFrame",null),m(t,"renderHighlightedNodesFrame",null),m(t,"needToProcess",!1),m(t,"checkEdgesEventsFrame",null),m(t,"nodePrograms",{}),m(t,"nodeHoverPrograms",{}),m(t,"edgePrograms",{}),t.settings=gr(a),We(t.settings),dr(r),!(e instanceof HTMLElement))throw new Error("Sigma: container should be an html element.");t.graph=r,t.container=e,t.createWebGLContext("edges",{picking:a.enableEdgeEvents}),t.createCanvasContext("edgeLabels"),t.createWebGLContext("nodes",{picking:!0}),t.createCanvasContext("labels"),t.createCanvasContext("hovers"),t.createWebGLContext("hoverNodes"),t.createCanvasContext("mouse",{style:{touchAction:"none",userSelect:"none"}}),t.resize();for(var o in t.settings.nodeProgramClasses)t.registerNodeProgram(o,t.settings.nodeProgramClasses[o],t.settings.nodeHoverProgramClasses[o]);for(var s in t.settings.edgeProgramClasses)t.registerEdgeProgram(s,t.settings.edgeProgramClasses[s]);return t.camera=new vr,t.bindCameraHandlers(),t.mouseCaptor=new Oi(t.elements.mouse,t),t.mouseCaptor.setSettings(t.settings),t.touchCaptor=new Mi(t.elements.mouse,t),t.touchCaptor.setSettings(t.settings),t.bindEventHandlers(),t.bindGraphHandlers(),t.handleSettingsUpdate(),t.refresh(),t}return V(n,i),z(n,[{key:"registerNodeProgram",value:function(e,t,a){return this.nodePrograms[e]&&this.nodePrograms[e].kill(),this.nodeHoverPrograms[e]&&this.nodeHoverPrograms[e].kill(),this.nodePrograms[e]=new t(this.webGLContexts.nodes,this.frameBuffers.nodes,this),this.nodeHoverPrograms[e]=new(a||t)(this.webGLContexts.hoverNodes,null,this),this}},{key:"registerEdgeProgram",value:function(e,t){return this.edgePrograms[e]&&this.edgePrograms[e].kill(),this.edgePrograms[e]=new t(this.webGLContexts.edges,this.frameBuffers.edges,this),this}},{key:"unregisterNodeProgram",value:function(e){if(this.nodePrograms[e]){var t=this.nodePrograms,a=t[e],o=pt(t,[e].map(ue));a.kill(),this.nodePrograms=o}if(this.nodeHoverPrograms[e]){var s=this.nodeHoverPrograms,l=s[e],u=pt(s,[e].map(ue));l.kill(),this.nodePrograms=u}return this}},{key:"unregisterEdgeProgram",value:function(e){if(this.edgePrograms[e]){var t=this.edgePrograms,a=t[e],o=pt(t,[e].map(ue));a.kill(),this.edgePrograms=o}return this}},{key:"resetWebGLTexture",value:function(e){var t=this.webGLContexts[e],a=this.frameBuffers[e],o=this.textures[e];o&&t.deleteTexture(o);var s=t.createTexture();return t.bindFramebuffer(t.FRAMEBUFFER,a),t.bindTexture(t.TEXTURE_2D,s),t.texImage2D(t.TEXTURE_2D,0,t.RGBA,this.width,this.height,0,t.RGBA,t.UNSIGNED_BYTE,null),t.framebufferTexture2D(t.FRAMEBUFFER,t.COLOR_ATTACHMENT0,t.TEXTURE_2D,s,0),this.textures[e]=s,this}},{key:"bindCameraHandlers",value:function(){var e=this;return this.activeListeners.camera=function(){e.scheduleRender()},this.camera.on("updated",this.activeListeners.camera),this}},{key:"unbindCameraHandlers",value:function(){return this.camera.removeListener("updated",this.activeListeners.camera),this}},{key:"getNodeAtPosition",value:function(e){var t=e.x,a=e.y,o=Ne(this.webGLContexts.nodes,this.frameBuffers.nodes,t,a,this.pixelRatio,this.pickingDownSizingRatio),s=ke.apply(void 0,mr(o)),l=this.itemIDsIndex[s];return l&&l.type==="node"?l.id:null}},{key:"bindEventHandlers",value:function(){var e=this;this.activeListeners.handleResize=function(){e.scheduleRefresh()},window.addEventListener("resize",this.activeListeners.handleResize),this.activeListeners.handleMove=function(a){var o=xe(a),s={event:o,preventSigmaDefault:function(){o.preventSigmaDefault()}},l=e.getNodeAtPosition(o);if(l&&e.hoveredNode!==l&&!e.nodeDataCache[l].hidden){e.hoveredNode&&e.emit("leaveNode",S(S({},s),{},{node:e.hoveredNode})),e.hoveredNode=l,e.emit("enterNode",S(S({},s),{},{node:l})),e.scheduleHighlightedNodesRender();return}if(e.hoveredNode&&e.getNodeAtPosition(o)!==e.hoveredNode){var u=e.hoveredNode;e.hoveredNode=null,e.emit("leaveNode",S(S({},s),{},{node:u})),e.scheduleHighlightedNodesRender();return}if(e.settings.enableEdgeEvents){var h=e.hoveredNode?null:e.getEdgeAtPoint(s.event.x,s.event.y);h!==e.hoveredEdge&&(e.hoveredEdge&&e.emit("leaveEdge",S(S({},s),{},{edge:e.hoveredEdge})),h&&e.emit("enterEdge",S(S({},s),{},{edge:h})),e.hoveredEdge=h)}},this.activeListeners.handleMoveBody=function(a){var o=xe(a);e.emit("moveBody",{event:o,preventSigmaDefault:function(){o.preventSigmaDefault()}})},this.activeListeners.handleLeave=function(a){var o=xe(a),s={event:o,preventSigmaDefault:function(){o.preventSigmaDefault()}};e.hoveredNode&&(e.emit("leaveNode",S(S({},s),{},{node:e.hoveredNode})),e.scheduleHighlightedNodesRender()),e.settings.enableEdgeEvents&&e.hoveredEdge&&(e.emit("leaveEdge",S(S({},s),{},{edge:e.hoveredEdge})),e.scheduleHighlightedNodesRender()),e.emit("leaveStage",S({},s))},this.activeListeners.handleEnter=function(a){var o=xe(a),s={event:o,preventSigmaDefault:function(){o.preventSigmaDefault()}};e.emit("enterStage",S({},s))};var t=function(o){return function(s){var l=xe(s),u={event:l,preventSigmaDefault:function(){l.preventSigmaDefault()}},h=e.getNodeAtPosition(l);if(h)return e.emit("".concat(o,"Node"),S(S({},u),{},{node:h}));if(e.settings.enableEdgeEvents){var c=e.getEdgeAtPoint(l.x,l.y);if(c)return e.emit("".concat(o,"Edge"),S(S({},u),{},{edge:c}))}return e.emit("".concat(o,"Stage"),u)}};return this.activeListeners.handleClick=t("click"),this.activeListeners.handleRightClick=t("rightClick"),this.activeListeners.handleDoubleClick=t("doubleClick"),this.activeListeners.handleWheel=t("wheel"),this.activeListeners.handleDown=t("down"),this.activeListeners.handleUp=t("up"),this.mouseCaptor.on("mousemove",this.activeListeners.handleMove),this.mouseCaptor.on("mousemovebody",this.activeListeners.handleMoveBody),this.mouseCaptor.on("click",this.activeListeners.handleClick),this.mouseCaptor.on("rightClick",this.activeListeners.handleRightClick),this.mouseCaptor.on("doubleClick",this.activeListeners.handleDoubleClick),this.mouseCaptor.on("wheel",this.activeListeners.handleWheel),this.mouseCaptor.on("mousedown",this.activeListeners.handleDown),this.mouseCaptor.on("mouseup",this.activeListeners.handleUp),this.mouseCaptor.on("mouseleave",this.activeListeners.handleLeave),this.mouseCaptor.on("mouseenter",this.activeListeners.handleEnter),this.touchCaptor.on("touchdown",this.activeListeners.handleDown),this.touchCaptor.on("touchdown",this.activeListeners.handleMove),this.touchCaptor.on("touchup",this.activeListeners.handleUp),this.touchCaptor.on("touchmove",this.activeListeners.handleMove),this.touchCaptor.on("tap",this.activeListeners.handleClick),this.touchCaptor.on("doubletap",this.activeListeners.handleDoubleClick),this.touchCaptor.on("touchmove",this.activeListeners.handleMoveBody),this}},{key:"bindGraphHandlers",value:function(){var e=this,t=this.graph,a=new Set(["x","y","zIndex","type"]);return this.activeListeners.eachNodeAttributesUpdatedGraphUpdate=function(o){var s,l=(s=o.hints)===null||s===void 0?void 0:s.attributes;e.graph.forEachNode(function(h){return e.updateNode(h)});var u=!l||l.some(function(h){return a.has(h)});e.refresh({partialGraph:{nodes:t.nodes()},skipIndexation:!u,schedule:!0})},this.activeListeners.eachEdgeAttributesUpdatedGraphUpdate=function(o){var s,l=(s=o.hints)===null||s===void 0?void 0:s.attributes;e.graph.forEachEdge(function(h){return e.updateEdge(h)});var u=l&&["zIndex","type"].some(function(h){return l?.includes(h)});e.refresh({partialGraph:{edges:t.edges()},skipIndexation:!u,schedule:!0})},this.activeListeners.addNodeGraphUpdate=function(o){var s=o.key;e.addNode(s),e.refresh({partialGraph:{nodes:[s]},skipIndexation:!1,schedule:!0})},this.activeListeners.updateNodeGraphUpdate=function(o){var s=o.key;e.refresh({partialGraph:{nodes:[s]},skipIndexation:!1,schedule:!0})},this.activeListeners.dropNodeGraphUpdate=function(o){var s=o.key;e.removeNode(s),e.refresh({schedule:!0})},this.activeListeners.addEdgeGraphUpdate=function(o){var s=o.key;e.addEdge(s),e.refresh({partialGraph:{edges:[s]},schedule:!0})},this.activeListeners.updateEdgeGraphUpdate=function(o){var s=o.key;e.refresh({partialGraph:{edges:[s]},skipIndexation:!1,schedule:!0})},this.activeListeners.dropEdgeGraphUpdate=function(o){var s=o.key;e.removeEdge(s),e.refresh({schedule:!0})},this.activeListeners.clearEdgesGraphUpdate=function(){e.clearEdgeState(),e.clearEdgeIndices(),e.refresh({schedule:!0})},this.activeListeners.clearGraphUpdate=function(){e.clearEdgeState(),e.clearNodeState(),e.clearEdgeIndices(),e.clearNodeIndices(),e.refresh({schedule:!0})},t.on("nodeAdded",this.activeListeners.addNodeGraphUpdate),t.on("nodeDropped",this.activeListeners.dropNodeGraphUpdate),t.on("nodeAttributesUpdated",this.activeListeners.updateNodeGraphUpdate),t.on("eachNodeAttributesUpdated",this.activeListeners.eachNodeAttributesUpdatedGraphUpdate),t.on("edgeAdded",this.activeListeners.addEdgeGraphUpdate),t.on("edgeDropped",this.activeListeners.dropEdgeGraphUpdate),t.on("edgeAttributesUpdated",this.activeListeners.updateEdgeGraphUpdate),t.on("eachEdgeAttributesUpdated",this.activeListeners.eachEdgeAttributesUpdatedGraphUpdate),t.on("edgesCleared",this.activeListeners.clearEdgesGraphUpdate),t.on("cleared",this.activeListeners.clearGraphUpdate),this}},{key:"unbindGraphHandlers",value:function(){var e=this.graph;e.removeListener("nodeAdded",this.activeListeners.addNodeGraphUpdate),e.removeListener("nodeDropped",this.activeListeners.dropNodeGraphUpdate),e.removeListener("nodeAttributesUpdated",this.activeListeners.updateNodeGraphUpdate),e.removeListener("eachNodeAttributesUpdated",this.activeListeners.eachNodeAttributesUpdatedGraphUpdate),e.removeListener("edgeAdded",this.activeListeners.addEdgeGraphUpdate),e.removeListener("edgeDropped",this.activeListeners.dropEdgeGraphUpdate),e.removeListener("edgeAttributesUpdated",this.activeListeners.updateEdgeGraphUpdate),e.removeListener("eachEdgeAttributesUpdated",this.activeListeners.eachEdgeAttributesUpdatedGraphUpdate),e.removeListener("edgesCleared",this.activeListeners.clearEdgesGraphUpdate),e.removeListener("cleared",this.activeListeners.clearGraphUpdate)}},{key:"getEdgeAtPoint",value:function(e,t){var a=Ne(this.webGLContexts.edges,this.frameBuffers.edges,e,t,this.pixelRatio,this.pickingDownSizingRatio),o=ke.apply(void 0,mr(a)),s=this.itemIDsIndex[o];return s&&s.type==="edge"?s.id:null}},{key:"process",value:function(){var e=this;this.emit("beforeProcess");var t=this.graph,a=this.settings,o=this.getDimensions();if(this.nodeExtent=cr(this.graph),!this.settings.autoRescale){var s=o.width,l=o.height,u=this.nodeExtent,h=u.x,c=u.y;this.nodeExtent={x:[(h[0]+h[1])/2-s/2,(h[0]+h[1])/2+s/2],y:[(c[0]+c[1])/2-l/2,(c[0]+c[1])/2+l/2]}}this.normalizationFunction=vt(this.customBBox||this.nodeExtent);var f=new vr,v=be(f.getState(),o,this.getGraphDimensions(),this.getStagePadding());this.labelGrid.resizeAndClear(o,a.labelGridCellSize);for(var T={},b={},R={},_={},g=1,d=t.nodes(),E=0,P=d.length;E<P;E++){var L=d[E],C=this.nodeDataCache[L],I=t.getNodeAttributes(L);C.x=I.x,C.y=I.y,this.normalizationFunction.applyTo(C),typeof C.label=="string"&&!C.hidden&&this.labelGrid.add(L,C.size,this.framedGraphToViewport(C,{matrix:v})),T[C.type]=(T[C.type]||0)+1}this.labelGrid.organize();for(var D in this.nodePrograms){if(!te.call(this.nodePrograms,D))throw new Error('Sigma: could not find a suitable program for node type "'.concat(D,'"!'));this.nodePrograms[D].reallocate(T[D]||0),T[D]=0}this.settings.zIndex&&this.nodeZExtent[0]!==this.nodeZExtent[1]&&(d=gt(this.nodeZExtent,function(J){return e.nodeDataCache[J].zIndex},d));for(var N=0,B=d.length;N<B;N++){var U=d[N];b[U]=g,_[b[U]]={type:"node",id:U},g++;var Y=this.nodeDataCache[U];this.addNodeToProgram(U,b[U],T[Y.type]++)}for(var M={},W=t.edges(),p=0,y=W.length;p<y;p++){var x=W[p],A=this.edgeDataCache[x];M[A.type]=(M[A.type]||0)+1}this.settings.zIndex&&this.edgeZExtent[0]!==this.edgeZExtent[1]&&(W=gt(this.edgeZExtent,function(J){return e.edgeDataCache[J].zIndex},W));for(var w in this.edgePrograms){if(!te.call(this.edgePrograms,w))throw new Error('Sigma: could not find a suitable program for edge type "'.concat(w,'"!'));this.edgePrograms[w].reallocate(M[w]||0),M[w]=0}for(var k=0,O=W.length;k<O;k++){var F=W[k];R[F]=g,_[R[F]]={type:"edge",id:F},g++;var X=this.edgeDataCache[F];this.addEdgeToProgram(F,R[F],M[X.type]++)}return this.itemIDsIndex=_,this.nodeIndices=b,this.edgeIndices=R,this.emit("afterProcess"),this}},{key:"handleSettingsUpdate",value:function(e){var t=this,a=this.settings;if(this.camera.minRatio=a.minCameraRatio,this.camera.maxRatio=a.maxCameraRatio,this.camera.enabledZooming=a.enableCameraZooming,this.camera.enabledPanning=a.enableCameraPanning,this.camera.enabledRotation=a.enableCameraRotation,a.cameraPanBoundaries?this.camera.clean=function(h){return t.cleanCameraState(h,a.cameraPanBoundaries&&Be(a.cameraPanBoundaries)==="object"?a.cameraPanBoundaries:{})}:this.camera.clean=null,this.camera.setState(this.camera.validateState(this.camera.getState())),e){if(e.edgeProgramClasses!==a.edgeProgramClasses){for(var o in a.edgeProgramClasses)a.edgeProgramClasses[o]!==e.edgeProgramClasses[o]&&this.registerEdgeProgram(o,a.edgeProgramClasses[o]);for(var s in e.edgeProgramClasses)a.edgeProgramClasses[s]||this.unregisterEdgeProgram(s)}if(e.nodeProgramClasses!==a.nodeProgramClasses||e.nodeHoverProgramClasses!==a.nodeHoverProgramClasses){for(var l in a.nodeProgramClasses)(a.nodeProgramClasses[l]!==e.nodeProgramClasses[l]||a.nodeHoverProgramClasses[l]!==e.nodeHoverProgramClasses[l])&&this.registerNodeProgram(l,a.nodeProgramClasses[l],a.nodeHoverProgramClasses[l]);for(var u in e.nodeProgramClasses)a.nodeProgramClasses[u]||this.unregisterNodeProgram(u)}}return this.mouseCaptor.setSettings(this.settings),this.touchCaptor.setSettings(this.settings),this}},{key:"cleanCameraState",value:function(e){var t=arguments.length>1&&arguments[1]!==void 0?arguments[1]:{},a=t.tolerance,o=a===void 0?0:a,s=t.boundaries,l=S({},e),u=s||this.nodeExtent,h=ae(u.x,2),c=h[0],f=h[1],v=ae(u.y,2),T=v[0],b=v[1],R=[this.graphToViewport({x:c,y:T},{cameraState:e}),this.graphToViewport({x:f,y:T},{cameraState:e}),this.graphToViewport({x:c,y:b},{cameraState:e}),this.graphToViewport({x:f,y:b},{cameraState:e})],_=1/0,g=-1/0,d=1/0,E=-1/0;R.forEach(function(M){var W=M.x,p=M.y;_=Math.min(_,W),g=Math.max(g,W),d=Math.min(d,p),E=Math.max(E,p)});var P=g-_,L=E-d,C=this.getDimensions(),I=C.width,D=C.height,N=0,B=0;if(P>=I?g<I-o?N=g-(I-o):_>o&&(N=_-o):g>I+o?N=g-(I+o):_<-o&&(N=_+o),L>=D?E<D-o?B=E-(D-o):d>o&&(B=d-o):E>D+o?B=E-(D+o):d<-o&&(B=d+o),N||B){var U=this.viewportToFramedGraph({x:0,y:0},{cameraState:e}),Y=this.viewportToFramedGraph({x:N,y:B},{cameraState:e});N=Y.x-U.x,B=Y.y-U.y,l.x+=N,l.y+=B}return l}},{key:"renderLabels",value:function(){if(!this.settings.renderLabels)return this;var e=this.camera.getState(),t=this.labelGrid.getLabelsToDisplay(e.ratio,this.settings.labelDensity);mt(t,this.nodesWithForcedLabels),this.displayedNodeLabels=new Set;for(var a=this.canvasContexts.labels,o=0,s=t.length;o<s;o++){var l=t[o],u=this.nodeDataCache[l];if(!this.displayedNodeLabels.has(l)&&!u.hidden){var h=this.framedGraphToViewport(u),c=h.x,f=h.y,v=this.scaleSize(u.size);if(!(!u.forceLabel&&v<this.settings.labelRenderedSizeThreshold)&&!(c<-yr||c>this.width+yr||f<-Er||f>this.height+Er)){this.displayedNodeLabels.add(l);var T=this.settings.defaultDrawNodeLabel,b=this.nodePrograms[u.type],R=b?.drawLabel||T;R(a,S(S({key:l},u),{},{size:v,x:c,y:f}),this.settings)}}}return this}},{key:"renderEdgeLabels",value:function(){if(!this.settings.renderEdgeLabels)return this;var e=this.canvasContexts.edgeLabels;e.clearRect(0,0,this.width,this.height);var t=Wi({graph:this.graph,hoveredNode:this.hoveredNode,displayedNodeLabels:this.displayedNodeLabels,highlightedNodes:this.highlightedNodes});mt(t,this.edgesWithForcedLabels);for(var a=new Set,o=0,s=t.length;o<s;o++){var l=t[o],u=this.graph.extremities(l),h=this.nodeDataCache[u[0]],c=this.nodeDataCache[u[1]],f=this.edgeDataCache[l];if(!a.has(l)&&!(f.hidden||h.hidden||c.hidden)){var v=this.settings.defaultDrawEdgeLabel,T=this.edgePrograms[f.type],b=T?.drawLabel||v;b(e,S(S({key:l},f),{},{size:this.scaleSize(f.size)}),S(S(S({key:u[0]},h),this.framedGraphToViewport(h)),{},{size:this.scaleSize(h.size)}),S(S(S({key:u[1]},c),this.framedGraphToViewport(c)),{},{size:this.scaleSize(c.size)}),this.settings),a.add(l)}}return this.displayedEdgeLabels=a,this}},{key:"renderHighlightedNodes",value:function(){var e=this,t=this.canvasContexts.hovers;t.clearRect(0,0,this.width,this.height);var a=function(v){var T=e.nodeDataCache[v],b=e.framedGraphToViewport(T),R=b.x,_=b.y,g=e.scaleSize(T.size),d=e.settings.defaultDrawNodeHover,E=e.nodePrograms[T.type],P=E?.drawHover||d;P(t,S(S({key:v},T),{},{size:g,x:R,y:_}),e.settings)},o=[];this.hoveredNode&&!this.nodeDataCache[this.hoveredNode].hidden&&o.push(this.hoveredNode),this.highlightedNodes.forEach(function(f){f!==e.hoveredNode&&o.push(f)}),o.forEach(function(f){return a(f)});var s={};o.forEach(function(f){var v=e.nodeDataCache[f].type;s[v]=(s[v]||0)+1});for(var l in this.nodeHoverPrograms)this.nodeHoverPrograms[l].reallocate(s[l]||0),s[l]=0;o.forEach(function(f){var v=e.nodeDataCache[f];e.nodeHoverPrograms[v.type].process(0,s[v.type]++,v)}),this.webGLContexts.hoverNodes.clear(this.webGLContexts.hoverNodes.COLOR_BUFFER_BIT);var u=this.getRenderParams();for(var h in this.nodeHoverPrograms){var c=this.nodeHoverPrograms[h];c.render(u)}}},{key:"scheduleHighlightedNodesRender",value:function(){var e=this;this.renderHighlightedNodesFrame||this.renderFrame||(this.renderHighlightedNodesFrame=requestAnimationFrame(function(){e.renderHighlightedNodesFrame=null,e.renderHighlightedNodes(),e.renderEdgeLabels()}))}},{key:"render",value:function(){var e=this;this.emit("beforeRender");var t=function(){return e.emit("afterRender"),e};if(this.renderFrame&&(cancelAnimationFrame(this.renderFrame),this.renderFrame=null),this.resize(),this.needToProcess&&this.process(),this.needToProcess=!1,this.clear(),this.pickingLayers.forEach(function(R){return e.resetWebGLTexture(R)}),!this.graph.order)return t();var a=this.mouseCaptor,o=this.camera.isAnimated()||a.isMoving||a.draggedEvents||a.currentWheelDirection,s=this.camera.getState(),l=this.getDimensions(),u=this.getGraphDimensions(),h=this.getStagePadding();this.matrix=be(s,l,u,h),this.invMatrix=be(s,l,u,h,!0),this.correctionRatio=hr(this.matrix,s,l),this.graphToViewportRatio=this.getGraphToViewportRatio();var c=this.getRenderParams();for(var f in this.nodePrograms){var v=this.nodePrograms[f];v.render(c)}if(!this.settings.hideEdgesOnMove||!o)for(var T in this.edgePrograms){var b=this.edgePrograms[T];b.render(c)}return this.settings.hideLabelsOnMove&&o||(this.renderLabels(),this.renderEdgeLabels(),this.renderHighlightedNodes()),t()}},{key:"addNode",value:function(e){var t=Object.assign({},this.graph.getNodeAttributes(e));this.settings.nodeReducer&&(t=this.settings.nodeReducer(e,t));var a=ji(this.settings,e,t);this.nodeDataCache[e]=a,this.nodesWithForcedLabels.delete(e),a.forceLabel&&!a.hidden&&this.nodesWithForcedLabels.add(e),this.highlightedNodes.delete(e),a.highlighted&&!a.hidden&&this.highlightedNodes.add(e),this.settings.zIndex&&(a.zIndex<this.nodeZExtent[0]&&(this.nodeZExtent[0]=a.zIndex),a.zIndex>this.nodeZExtent[1]&&(this.nodeZExtent[1]=a.zIndex))}},{key:"updateNode",value:function(e){this.addNode(e);var t=this.nodeDataCache[e];this.normalizationFunction.applyTo(t)}},{key:"removeNode",value:function(e){delete this.nodeDataCache[e],delete this.nodeProgramIndex[e],this.highlightedNodes.delete(e),this.hoveredNode===e&&(this.hoveredNode=null),this.nodesWithForcedLabels.delete(e)}},{key:"addEdge",value:function(e){var t=Object.assign({},this.graph.getEdgeAttributes(e));this.settings.edgeReducer&&(t=this.settings.edgeReducer(e,t));var a=Xi(this.settings,e,t);this.edgeDataCache[e]=a,this.edgesWithForcedLabels.delete(e),a.forceLabel&&!a.hidden&&this.edgesWithForcedLabels.add(e),this.settings.zIndex&&(a.zIndex<this.edgeZExtent[0]&&(this.edgeZExtent[0]=a.zIndex),a.zIndex>this.edgeZExtent[1]&&(this.edgeZExtent[1]=a.zIndex))}},{key:"updateEdge",value:function(e){this.addEdge(e)}},{key:"removeEdge",value:function(e){delete this.edgeDataCache[e],delete this.edgeProgramIndex[e],this.hoveredEdge===e&&(this.hoveredEdge=null),this.edgesWithForcedLabels.delete(e)}},{key:"clearNodeIndices",value:function(){this.labelGrid=new br,this.nodeExtent={x:[0,1],y:[0,1]},this.nodeDataCache={},this.edgeProgramIndex={},this.nodesWithForcedLabels=new Set,this.nodeZExtent=[1/0,-1/0],this.highlightedNodes=new Set}},{key:"clearEdgeIndices",value:function(){this.edgeDataCache={},this.edgeProgramIndex={},this.edgesWithForcedLabels=new Set,this.edgeZExtent=[1/0,-1/0]}},{key:"clearIndices",value:function(){this.clearEdgeIndices(),this.clearNodeIndices()}},{key:"clearNodeState",value:function(){this.displayedNodeLabels=new Set,this.highlightedNodes=new Set,this.hoveredNode=null}},{key:"clearEdgeState",value:function(){this.displayedEdgeLabels=new Set,this.highlightedNodes=new Set,this.hoveredEdge=null}},{key:"clearState",value:function(){this.clearEdgeState(),this.clearNodeState()}},{key:"addNodeToProgram",value:function(e,t,a){var o=this.nodeDataCache[e],s=this.nodePrograms[o.type];if(!s)throw new Error('Sigma: could not find a suitable program for node type "'.concat(o.type,'"!'));s.process(t,a,o),this.nodeProgramIndex[e]=a}},{key:"addEdgeToProgram",value:function(e,t,a){var o=this.edgeDataCache[e],s=this.edgePrograms[o.type];if(!s)throw new Error('Sigma: could not find a suitable program for edge type "'.concat(o.type,'"!'));var l=this.graph.extremities(e),u=this.nodeDataCache[l[0]],h=this.nodeDataCache[l[1]];s.process(t,a,u,h,o),this.edgeProgramIndex[e]=a}},{key:"getRenderParams",value:function(){return{matrix:this.matrix,invMatrix:this.invMatrix,width:this.width,height:this.height,pixelRatio:this.pixelRatio,zoomRatio:this.camera.ratio,cameraAngle:this.camera.angle,sizeRatio:1/this.scaleSize(),correctionRatio:this.correctionRatio,downSizingRatio:this.pickingDownSizingRatio,minEdgeThickness:this.settings.minEdgeThickness,antiAliasingFeather:this.settings.antiAliasingFeather}}},{key:"getStagePadding",value:function(){var e=this.settings,t=e.stagePadding,a=e.autoRescale;return a&&t||0}},{key:"createLayer",value:function(e,t){var a=arguments.length>2&&arguments[2]!==void 0?arguments[2]:{};if(this.elements[e])throw new Error('Sigma: a layer named "'.concat(e,'" already exists'));var o=fr(t,{position:"absolute"},{class:"sigma-".concat(e)});return a.style&&Object.assign(o.style,a.style),this.elements[e]=o,"beforeLayer"in a&&a.beforeLayer?this.elements[a.beforeLayer].before(o):"afterLayer"in a&&a.afterLayer?this.elements[a.afterLayer].after(o):this.container.appendChild(o),o}},{key:"createCanvas",value:function(e){var t=arguments.length>1&&arguments[1]!==void 0?arguments[1]:{};return this.createLayer(e,"canvas",t)}},{key:"createCanvasContext",value:function(e){var t=arguments.length>1&&arguments[1]!==void 0?arguments[1]:{},a=this.createCanvas(e,t),o={preserveDrawingBuffer:!1,antialias:!1};return this.canvasContexts[e]=a.getContext("2d",o),this}},{key:"createWebGLContext",value:function(e){var t=arguments.length>1&&arguments[1]!==void 0?arguments[1]:{},a=t?.canvas||this.createCanvas(e,t);t.hidden&&a.remove();var o=S({preserveDrawingBuffer:!1,antialias:!1},t),s;s=a.getContext("webgl2",o),s||(s=a.getContext("webgl",o)),s||(s=a.getContext("experimental-webgl",o));var l=s;if(this.webGLContexts[e]=l,l.blendFunc(l.ONE,l.ONE_MINUS_SRC_ALPHA),t.picking){this.pickingLayers.add(e);var u=l.createFramebuffer();if(!u)throw new Error("Sigma: cannot create a new frame buffer for layer ".concat(e));this.frameBuffers[e]=u}return l}},{key:"killLayer",value:function(e){var t=this.elements[e];if(!t)throw new Error("Sigma: cannot kill layer ".concat(e,", which does not exist"));if(this.webGLContexts[e]){var a,o=this.webGLContexts[e];(a=o.getExtension("WEBGL_lose_context"))===null||a===void 0||a.loseContext(),delete this.webGLContexts[e]}else this.canvasContexts[e]&&delete this.canvasContexts[e];return t.remove(),delete this.elements[e],this}},{key:"getCamera",value:function(){return this.camera}},{key:"setCamera",value:function(e){this.unbindCameraHandlers(),this.camera=e,this.bindCameraHandlers()}},{key:"getContainer",value:function(){return this.container}},{key:"getGraph",value:function(){return this.graph}},{key:"setGraph",value:function(e){e!==this.graph&&(this.hoveredNode&&!e.hasNode(this.hoveredNode)&&(this.hoveredNode=null),this.hoveredEdge&&!e.hasEdge(this.hoveredEdge)&&(this.hoveredEdge=null),this.unbindGraphHandlers(),this.checkEdgesEventsFrame!==null&&(cancelAnimationFrame(this.checkEdgesEventsFrame),this.checkEdgesEventsFrame=null),this.graph=e,this.bindGraphHandlers(),this.refresh())}},{key:"getMouseCaptor",value:function(){return this.mouseCaptor}},{key:"getTouchCaptor",value:function(){return this.touchCaptor}},{key:"getDimensions",value:function(){return{width:this.width,height:this.height}}},{key:"getGraphDimensions",value:function(){var e=this.customBBox||this.nodeExtent;return{width:e.x[1]-e.x[0]||1,height:e.y[1]-e.y[0]||1}}},{key:"getNodeDisplayData",value:function(e){var t=this.nodeDataCache[e];return t?Object.assign({},t):void 0}},{key:"getEdgeDisplayData",value:function(e){var t=this.edgeDataCache[e];return t?Object.assign({},t):void 0}},{key:"getNodeDisplayedLabels",value:function(){return new Set(this.displayedNodeLabels)}},{key:"getEdgeDisplayedLabels",value:function(){return new Set(this.displayedEdgeLabels)}},{key:"getSettings",value:function(){return S({},this.settings)}},{key:"getSetting",value:function(e){return this.settings[e]}},{key:"setSetting",value:function(e,t){var a=S({},this.settings);return this.settings[e]=t,We(this.settings),this.handleSettingsUpdate(a),this.scheduleRefresh(),this}},{key:"updateSetting",value:function(e,t){return this.setSetting(e,t(this.settings[e])),this}},{key:"setSettings",value:function(e){var t=S({},this.settings);return this.settings=S(S({},this.settings),e),We(this.settings),this.handleSettingsUpdate(t),this.scheduleRefresh(),this}},{key:"resize",value:function(e){var t=this.width,a=this.height;if(this.width=this.container.offsetWidth,this.height=this.container.offsetHeight,this.pixelRatio=ft(),this.width===0)if(this.settings.allowInvalidContainer)this.width=1;else throw new Error("Sigma: Container has no width. You can set the allowInvalidContainer setting to true to stop seeing this error.");if(this.height===0)if(this.settings.allowInvalidContainer)this.height=1;else throw new Error("Sigma: Container has no height. You can set the allowInvalidContainer setting to true to stop seeing this error.");if(!e&&t===this.width&&a===this.height)return this;for(var o in this.elements){var s=this.elements[o];s.style.width=this.width+"px",s.style.height=this.height+"px"}for(var l in this.canvasContexts)this.elements[l].setAttribute("width",this.width*this.pixelRatio+"px"),this.elements[l].setAttribute("height",this.height*this.pixelRatio+"px"),this.pixelRatio!==1&&this.canvasContexts[l].scale(this.pixelRatio,this.pixelRatio);for(var u in this.webGLContexts){this.elements[u].setAttribute("width",this.width*this.pixelRatio+"px"),this.elements[u].setAttribute("height",this.height*this.pixelRatio+"px");var h=this.webGLContexts[u];if(h.viewport(0,0,this.width*this.pixelRatio,this.height*this.pixelRatio),this.pickingLayers.has(u)){var c=this.textures[u];c&&h.deleteTexture(c)}}return this.emit("resize"),this}},{key:"clear",value:function(){return this.emit("beforeClear"),this.webGLContexts.nodes.bindFramebuffer(WebGLRenderingContext.FRAMEBUFFER,null),this.webGLContexts.nodes.clear(WebGLRenderingContext.COLOR_BUFFER_BIT),this.webGLContexts.edges.bindFramebuffer(WebGLRenderingContext.FRAMEBUFFER,null),this.webGLContexts.edges.clear(WebGLRenderingContext.COLOR_BUFFER_BIT),this.webGLContexts.hoverNodes.clear(WebGLRenderingContext.COLOR_BUFFER_BIT),this.canvasContexts.labels.clearRect(0,0,this.width,this.height),this.canvasContexts.hovers.clearRect(0,0,this.width,this.height),this.canvasContexts.edgeLabels.clearRect(0,0,this.width,this.height),this.emit("afterClear"),this}},{key:"refresh",value:function(e){var t=this,a=e?.skipIndexation!==void 0?e?.skipIndexation:!1,o=e?.schedule!==void 0?e.schedule:!1,s=!e||!e.partialGraph;if(s)this.clearEdgeIndices(),this.clearNodeIndices(),this.graph.forEachNode(function(E){return t.addNode(E)}),this.graph.forEachEdge(function(E){return t.addEdge(E)});else{for(var l,u,h=((l=e.partialGraph)===null||l===void 0?void 0:l.nodes)||[],c=0,f=h?.length||0;c<f;c++){var v=h[c];if(this.updateNode(v),a){var T=this.nodeProgramIndex[v];if(T===void 0)throw new Error('Sigma: node "'.concat(v,`" can't be repaint`));this.addNodeToProgram(v,this.nodeIndices[v],T)}}for(var b=(e==null||(u=e.partialGraph)===null||u===void 0?void 0:u.edges)||[],R=0,_=b.length;R<_;R++){var g=b[R];if(this.updateEdge(g),a){var d=this.edgeProgramIndex[g];if(d===void 0)throw new Error('Sigma: edge "'.concat(g,`" can't be repaint`));this.addEdgeToProgram(g,this.edgeIndices[g],d)}}}return(s||!a)&&(this.needToProcess=!0),o?this.scheduleRender():this.render(),this}},{key:"scheduleRender",value:function(){var e=this;return this.renderFrame||(this.renderFrame=requestAnimationFrame(function(){e.render()})),this}},{key:"scheduleRefresh",value:function(e){return this.refresh(S(S({},e),{},{schedule:!0}))}},{key:"getViewportZoomedState",value:function(e,t){var a=this.camera.getState(),o=a.ratio,s=a.angle,l=a.x,u=a.y,h=this.settings,c=h.minCameraRatio,f=h.maxCameraRatio;typeof f=="number"&&(t=Math.min(t,f)),typeof c=="number"&&(t=Math.max(t,c));var v=t/o,T={x:this.width/2,y:this.height/2},b=this.viewportToFramedGraph(e),R=this.viewportToFramedGraph(T);return{angle:s,x:(b.x-R.x)*(1-v)+l,y:(b.y-R.y)*(1-v)+u,ratio:t}}},{key:"viewRectangle",value:function(){var e=this.viewportToFramedGraph({x:0,y:0}),t=this.viewportToFramedGraph({x:this.width,y:0}),a=this.viewportToFramedGraph({x:0,y:this.height});return{x1:e.x,y1:e.y,x2:t.x,y2:t.y,height:t.y-a.y}}},{key:"framedGraphToViewport",value:function(e){var t=arguments.length>1&&arguments[1]!==void 0?arguments[1]:{},a=!!t.cameraState||!!t.viewportDimensions||!!t.graphDimensions,o=t.matrix?t.matrix:a?be(t.cameraState||this.camera.getState(),t.viewportDimensions||this.getDimensions(),t.graphDimensions||this.getGraphDimensions(),t.padding||this.getStagePadding()):this.matrix,s=Ue(o,e);return{x:(1+s.x)*this.width/2,y:(1-s.y)*this.height/2}}},{key:"viewportToFramedGraph",value:function(e){var t=arguments.length>1&&arguments[1]!==void 0?arguments[1]:{},a=!!t.cameraState||!!t.viewportDimensions||!t.graphDimensions,o=t.matrix?t.matrix:a?be(t.cameraState||this.camera.getState(),t.viewportDimensions||this.getDimensions(),t.graphDimensions||this.getGraphDimensions(),t.padding||this.getStagePadding(),!0):this.invMatrix,s=Ue(o,{x:e.x/this.width*2-1,y:1-e.y/this.height*2});return isNaN(s.x)&&(s.x=0),isNaN(s.y)&&(s.y=0),s}},{key:"viewportToGraph",value:function(e){var t=arguments.length>1&&arguments[1]!==void 0?arguments[1]:{};return this.normalizationFunction.inverse(this.viewportToFramedGraph(e,t))}},{key:"graphToViewport",value:function(e){var t=arguments.length>1&&arguments[1]!==void 0?arguments[1]:{};return this.framedGraphToViewport(this.normalizationFunction(e),t)}},{key:"getGraphToViewportRatio",value:function(){var e={x:0,y:0},t={x:1,y:1},a=Math.sqrt(Math.pow(e.x-t.x,2)+Math.pow(e.y-t.y,2)),o=this.graphToViewport(e),s=this.graphToViewport(t),l=Math.sqrt(Math.pow(o.x-s.x,2)+Math.pow(o.y-s.y,2));return l/a}},{key:"getBBox",value:function(){return this.nodeExtent}},{key:"getCustomBBox",value:function(){return this.customBBox}},{key:"setCustomBBox",value:function(e){return this.customBBox=e,this.scheduleRender(),this}},{key:"kill",value:function(){this.emit("kill"),this.removeAllListeners(),this.unbindCameraHandlers(),window.removeEventListener("resize",this.activeListeners.handleResize),this.mouseCaptor.kill(),this.touchCaptor.kill(),this.unbindGraphHandlers(),this.clearIndices(),this.clearState(),this.nodeDataCache={},this.edgeDataCache={},this.highlightedNodes.clear(),this.renderFrame&&(cancelAnimationFrame(this.renderFrame),this.renderFrame=null),this.renderHighlightedNodesFrame&&(cancelAnimationFrame(this.renderHighlightedNodesFrame),this.renderHighlightedNodesFrame=null);for(var e=this.container;e.firstChild;)e.removeChild(e.firstChild);for(var t in this.nodePrograms)this.nodePrograms[t].kill();for(var a in this.nodeHoverPrograms)this.nodeHoverPrograms[a].kill();for(var o in this.edgePrograms)this.edgePrograms[o].kill();this.nodePrograms={},this.nodeHoverPrograms={},this.edgePrograms={};for(var s in this.elements)this.killLayer(s);this.canvasContexts={},this.webGLContexts={},this.elements={}}},{key:"scaleSize",value:function(){var e=arguments.length>0&&arguments[0]!==void 0?arguments[0]:1,t=arguments.length>1&&arguments[1]!==void 0?arguments[1]:this.camera.ratio;return e/this.settings.zoomToSizeRatioFunction(t)*(this.getSetting("itemSizesReference")==="positions"?t*this.graphToViewportRatio:1)}},{key:"getCanvases",value:function(){var e={};for(var t in this.elements)this.elements[t]instanceof HTMLCanvasElement&&(e[t]=this.elements[t]);return e}}])})(ze),Rr=Yi;var qi=`
precision mediump float;

varying vec4 v_color;
varying float v_border;

const float radius = 0.5;
const vec4 transparent = vec4(0.0, 0.0, 0.0, 0.0);

void main(void) {
  vec2 m = gl_PointCoord - vec2(0.5, 0.5);
  float dist = radius - length(m);

  // No antialiasing for picking mode:
  #ifdef PICKING_MODE
  if (dist > v_border)
    gl_FragColor = v_color;
  else
    gl_FragColor = transparent;

  #else
  float t = 0.0;
  if (dist > v_border)
    t = 1.0;
  else if (dist > 0.0)
    t = dist / v_border;

  gl_FragColor = mix(transparent, v_color, t);
  #endif
}
`,Zi=qi,$i=`
attribute vec4 a_id;
attribute vec4 a_color;
attribute vec2 a_position;
attribute float a_size;

uniform float u_sizeRatio;
uniform float u_pixelRatio;
uniform mat3 u_matrix;

varying vec4 v_color;
varying float v_border;

const float bias = 255.0 / 254.0;

void main() {
  gl_Position = vec4(
    (u_matrix * vec3(a_position, 1)).xy,
    0,
    1
  );

  // Multiply the point size twice:
  //  - x SCALING_RATIO to correct the canvas scaling
  //  - x 2 to correct the formulae
  gl_PointSize = a_size / u_sizeRatio * u_pixelRatio * 2.0;

  v_border = (0.5 / a_size) * u_sizeRatio;

  #ifdef PICKING_MODE
  // For picking mode, we use the ID as the color:
  v_color = a_id;
  #else
  // For normal mode, we use the color:
  v_color = a_color;
  #endif

  v_color.a *= bias;
}
`,Ki=$i,Ar=WebGLRenderingContext,xr=Ar.UNSIGNED_BYTE,Cr=Ar.FLOAT,Qi=["u_sizeRatio","u_pixelRatio","u_matrix"],Lr=(function(i){function n(){return G(this,n),H(this,n,arguments)}return V(n,i),z(n,[{key:"getDefinition",value:function(){return{VERTICES:1,VERTEX_SHADER_SOURCE:Ki,FRAGMENT_SHADER_SOURCE:Zi,METHOD:WebGLRenderingContext.POINTS,UNIFORMS:Qi,ATTRIBUTES:[{name:"a_position",size:2,type:Cr},{name:"a_size",size:1,type:Cr},{name:"a_color",size:4,type:xr,normalized:!0},{name:"a_id",size:4,type:xr,normalized:!0}]}}},{key:"processVisibleItem",value:function(e,t,a){var o=this.array;o[t++]=a.x,o[t++]=a.y,o[t++]=a.size,o[t++]=q(a.color),o[t++]=e}},{key:"setUniforms",value:function(e,t){var a=e.sizeRatio,o=e.pixelRatio,s=e.matrix,l=t.gl,u=t.uniformLocations,h=u.u_sizeRatio,c=u.u_pixelRatio,f=u.u_matrix;l.uniform1f(c,o),l.uniform1f(h,a),l.uniformMatrix3fv(f,!1,s)}}])})(ve),Ji=`
attribute vec4 a_id;
attribute vec4 a_color;
attribute vec2 a_normal;
attribute float a_normalCoef;
attribute vec2 a_positionStart;
attribute vec2 a_positionEnd;
attribute float a_positionCoef;
attribute float a_sourceRadius;
attribute float a_targetRadius;
attribute float a_sourceRadiusCoef;
attribute float a_targetRadiusCoef;

uniform mat3 u_matrix;
uniform float u_zoomRatio;
uniform float u_sizeRatio;
uniform float u_pixelRatio;
uniform float u_correctionRatio;
uniform float u_minEdgeThickness;
uniform float u_lengthToThicknessRatio;
uniform float u_feather;

varying vec4 v_color;
varying vec2 v_normal;
varying float v_thickness;
varying float v_feather;

const float bias = 255.0 / 254.0;

void main() {
  float minThickness = u_minEdgeThickness;

  vec2 normal = a_normal * a_normalCoef;
  vec2 position = a_positionStart * (1.0 - a_positionCoef) + a_positionEnd * a_positionCoef;

  float normalLength = length(normal);
  vec2 unitNormal = normal / normalLength;

  // These first computations are taken from edge.vert.glsl. Please read it to
  // get better comments on what's happening:
  float pixelsThickness = max(normalLength, minThickness * u_sizeRatio);
  float webGLThickness = pixelsThickness * u_correctionRatio / u_sizeRatio;

  // Here, we move the point to leave space for the arrow heads:
  // Source arrow head
  float sourceRadius = a_sourceRadius * a_sourceRadiusCoef;
  float sourceDirection = sign(sourceRadius);
  float webGLSourceRadius = sourceDirection * sourceRadius * 2.0 * u_correctionRatio / u_sizeRatio;
  float webGLSourceArrowHeadLength = webGLThickness * u_lengthToThicknessRatio * 2.0;
  vec2 sourceCompensationVector =
    vec2(-sourceDirection * unitNormal.y, sourceDirection * unitNormal.x)
    * (webGLSourceRadius + webGLSourceArrowHeadLength);
    
  // Target arrow head
  float targetRadius = a_targetRadius * a_targetRadiusCoef;
  float targetDirection = sign(targetRadius);
  float webGLTargetRadius = targetDirection * targetRadius * 2.0 * u_correctionRatio / u_sizeRatio;
  float webGLTargetArrowHeadLength = webGLThickness * u_lengthToThicknessRatio * 2.0;
  vec2 targetCompensationVector =
  vec2(-targetDirection * unitNormal.y, targetDirection * unitNormal.x)
    * (webGLTargetRadius + webGLTargetArrowHeadLength);

  // Here is the proper position of the vertex
  gl_Position = vec4((u_matrix * vec3(position + unitNormal * webGLThickness + sourceCompensationVector + targetCompensationVector, 1)).xy, 0, 1);

  v_thickness = webGLThickness / u_zoomRatio;

  v_normal = unitNormal;

  v_feather = u_feather * u_correctionRatio / u_zoomRatio / u_pixelRatio * 2.0;

  #ifdef PICKING_MODE
  // For picking mode, we use the ID as the color:
  v_color = a_id;
  #else
  // For normal mode, we use the color:
  v_color = a_color;
  #endif

  v_color.a *= bias;
}
`,en=Ji,Pr=WebGLRenderingContext,Sr=Pr.UNSIGNED_BYTE,re=Pr.FLOAT,tn=["u_matrix","u_zoomRatio","u_sizeRatio","u_correctionRatio","u_pixelRatio","u_feather","u_minEdgeThickness","u_lengthToThicknessRatio"],rn={lengthToThicknessRatio:Re.lengthToThicknessRatio};function kr(i){var n=S(S({},rn),i||{});return(function(r){function e(){return G(this,e),H(this,e,arguments)}return V(e,r),z(e,[{key:"getDefinition",value:function(){return{VERTICES:6,VERTEX_SHADER_SOURCE:en,FRAGMENT_SHADER_SOURCE:Ge,METHOD:WebGLRenderingContext.TRIANGLES,UNIFORMS:tn,ATTRIBUTES:[{name:"a_positionStart",size:2,type:re},{name:"a_positionEnd",size:2,type:re},{name:"a_normal",size:2,type:re},{name:"a_color",size:4,type:Sr,normalized:!0},{name:"a_id",size:4,type:Sr,normalized:!0},{name:"a_sourceRadius",size:1,type:re},{name:"a_targetRadius",size:1,type:re}],CONSTANT_ATTRIBUTES:[{name:"a_positionCoef",size:1,type:re},{name:"a_normalCoef",size:1,type:re},{name:"a_sourceRadiusCoef",size:1,type:re},{name:"a_targetRadiusCoef",size:1,type:re}],CONSTANT_DATA:[[0,1,-1,0],[0,-1,1,0],[1,1,0,1],[1,1,0,1],[0,-1,1,0],[1,-1,0,-1]]}}},{key:"processVisibleItem",value:function(a,o,s,l,u){var h=u.size||1,c=s.x,f=s.y,v=l.x,T=l.y,b=q(u.color),R=v-c,_=T-f,g=s.size||1,d=l.size||1,E=R*R+_*_,P=0,L=0;E&&(E=1/Math.sqrt(E),P=-_*E*h,L=R*E*h);var C=this.array;C[o++]=c,C[o++]=f,C[o++]=v,C[o++]=T,C[o++]=P,C[o++]=L,C[o++]=b,C[o++]=a,C[o++]=g,C[o++]=d}},{key:"setUniforms",value:function(a,o){var s=o.gl,l=o.uniformLocations,u=l.u_matrix,h=l.u_zoomRatio,c=l.u_feather,f=l.u_pixelRatio,v=l.u_correctionRatio,T=l.u_sizeRatio,b=l.u_minEdgeThickness,R=l.u_lengthToThicknessRatio;s.uniformMatrix3fv(u,!1,a.matrix),s.uniform1f(h,a.zoomRatio),s.uniform1f(T,a.sizeRatio),s.uniform1f(v,a.correctionRatio),s.uniform1f(f,a.pixelRatio),s.uniform1f(c,a.antiAliasingFeather),s.uniform1f(b,a.minEdgeThickness),s.uniform1f(R,n.lengthToThicknessRatio)}}])})(ce)}var Ca=kr();function nn(i){return Ie([kr(i),pe(i),pe(S(S({},i),{},{extremity:"source"}))])}var Sa=nn();var an=`
precision mediump float;

varying vec4 v_color;

void main(void) {
  gl_FragColor = v_color;
}
`,on=an,sn=`
attribute vec4 a_id;
attribute vec4 a_color;
attribute vec2 a_position;

uniform mat3 u_matrix;

varying vec4 v_color;

const float bias = 255.0 / 254.0;

void main() {
  // Scale from [[-1 1] [-1 1]] to the container:
  gl_Position = vec4(
    (u_matrix * vec3(a_position, 1)).xy,
    0,
    1
  );

  #ifdef PICKING_MODE
  // For picking mode, we use the ID as the color:
  v_color = a_id;
  #else
  // For normal mode, we use the color:
  v_color = a_color;
  #endif

  v_color.a *= bias;
}
`,ln=sn,Nr=WebGLRenderingContext,wr=Nr.UNSIGNED_BYTE,un=Nr.FLOAT,hn=["u_matrix"],Dr=(function(i){function n(){return G(this,n),H(this,n,arguments)}return V(n,i),z(n,[{key:"getDefinition",value:function(){return{VERTICES:2,VERTEX_SHADER_SOURCE:ln,FRAGMENT_SHADER_SOURCE:on,METHOD:WebGLRenderingContext.LINES,UNIFORMS:hn,ATTRIBUTES:[{name:"a_position",size:2,type:un},{name:"a_color",size:4,type:wr,normalized:!0},{name:"a_id",size:4,type:wr,normalized:!0}]}}},{key:"processVisibleItem",value:function(e,t,a,o,s){var l=this.array,u=a.x,h=a.y,c=o.x,f=o.y,v=q(s.color);l[t++]=u,l[t++]=h,l[t++]=v,l[t++]=e,l[t++]=c,l[t++]=f,l[t++]=v,l[t++]=e}},{key:"setUniforms",value:function(e,t){var a=t.gl,o=t.uniformLocations,s=o.u_matrix;a.uniformMatrix3fv(s,!1,e.matrix)}}])})(ce);var Fr=WebGLRenderingContext,wa=Fr.UNSIGNED_BYTE,Aa=Fr.FLOAT;var Da=fe(Qe());var Ur=fe(Ke());function bt(i,n){(n==null||n>i.length)&&(n=i.length);for(var r=0,e=Array(n);r<n;r++)e[r]=i[r];return e}function cn(i){if(Array.isArray(i))return bt(i)}function dn(i){if(typeof Symbol<"u"&&i[Symbol.iterator]!=null||i["@@iterator"]!=null)return Array.from(i)}function fn(i,n){if(i){if(typeof i=="string")return bt(i,n);var r={}.toString.call(i).slice(8,-1);return r==="Object"&&i.constructor&&(r=i.constructor.name),r==="Map"||r==="Set"?Array.from(i):r==="Arguments"||/^(?:Ui|I)nt(?:8|16|32)(?:Clamped)?Array$/.test(r)?bt(i,n):void 0}}function gn(){throw new TypeError(`Invalid attempt to spread non-iterable instance.
In order to be iterable, non-array objects must have a [Symbol.iterator]() method.`)}function xt(i){return cn(i)||dn(i)||fn(i)||gn()}function Ct(i,n){if(!(i instanceof n))throw new TypeError("Cannot call a class as a function")}function vn(i,n){if(typeof i!="object"||!i)return i;var r=i[Symbol.toPrimitive];if(r!==void 0){var e=r.call(i,n||"default");if(typeof e!="object")return e;throw new TypeError("@@toPrimitive must return a primitive value.")}return(n==="string"?String:Number)(i)}function Br(i){var n=vn(i,"string");return typeof n=="symbol"?n:n+""}function Ir(i,n){for(var r=0;r<n.length;r++){var e=n[r];e.enumerable=e.enumerable||!1,e.configurable=!0,"value"in e&&(e.writable=!0),Object.defineProperty(i,Br(e.key),e)}}function St(i,n,r){return n&&Ir(i.prototype,n),r&&Ir(i,r),Object.defineProperty(i,"prototype",{writable:!1}),i}function ye(i){return ye=Object.setPrototypeOf?Object.getPrototypeOf.bind():function(n){return n.__proto__||Object.getPrototypeOf(n)},ye(i)}function Hr(){try{var i=!Boolean.prototype.valueOf.call(Reflect.construct(Boolean,[],function(){}))}catch{}return(Hr=function(){return!!i})()}function Q(i){if(i===void 0)throw new ReferenceError("this hasn't been initialised - super() hasn't been called");return i}function mn(i,n){if(n&&(typeof n=="object"||typeof n=="function"))return n;if(n!==void 0)throw new TypeError("Derived constructors may only return object or undefined");return Q(i)}function Vr(i,n,r){return n=ye(n),mn(i,Hr()?Reflect.construct(n,r||[],ye(i).constructor):n.apply(i,r))}function pn(i,n){for(;!{}.hasOwnProperty.call(i,n)&&(i=ye(i))!==null;);return i}function yt(){return yt=typeof Reflect<"u"&&Reflect.get?Reflect.get.bind():function(i,n,r){var e=pn(i,n);if(e){var t=Object.getOwnPropertyDescriptor(e,n);return t.get?t.get.call(arguments.length<3?i:r):t.value}},yt.apply(null,arguments)}function Or(i,n,r,e){var t=yt(ye(1&e?i.prototype:i),n,r);return 2&e&&typeof t=="function"?function(a){return t.apply(r,a)}:t}function Et(i,n){return Et=Object.setPrototypeOf?Object.setPrototypeOf.bind():function(r,e){return r.__proto__=e,r},Et(i,n)}function Wr(i,n){if(typeof n!="function"&&n!==null)throw new TypeError("Super expression must either be null or a function");i.prototype=Object.create(n&&n.prototype,{constructor:{value:i,writable:!0,configurable:!0}}),Object.defineProperty(i,"prototype",{writable:!1}),n&&Et(i,n)}function j(i,n,r){return(n=Br(n))in i?Object.defineProperty(i,n,{value:r,enumerable:!0,configurable:!0,writable:!0}):i[n]=r,i}function bn(i,n){if(i==null)return{};var r={};for(var e in i)if({}.hasOwnProperty.call(i,e)){if(n.includes(e))continue;r[e]=i[e]}return r}function yn(i,n){if(i==null)return{};var r,e,t=bn(i,n);if(Object.getOwnPropertySymbols){var a=Object.getOwnPropertySymbols(i);for(e=0;e<a.length;e++)r=a[e],n.includes(r)||{}.propertyIsEnumerable.call(i,r)&&(t[r]=i[r])}return t}function Gr(i,n){var r=Object.keys(i);if(Object.getOwnPropertySymbols){var e=Object.getOwnPropertySymbols(i);n&&(e=e.filter(function(t){return Object.getOwnPropertyDescriptor(i,t).enumerable})),r.push.apply(r,e)}return r}function Z(i){for(var n=1;n<arguments.length;n++){var r=arguments[n]!=null?arguments[n]:{};n%2?Gr(Object(r),!0).forEach(function(e){j(i,e,r[e])}):Object.getOwnPropertyDescriptors?Object.defineProperties(i,Object.getOwnPropertyDescriptors(r)):Gr(Object(r)).forEach(function(e){Object.defineProperty(i,e,Object.getOwnPropertyDescriptor(r,e))})}return i}function En(i){var n=i.texturesCount,r=`
precision highp float;

varying vec4 v_color;
varying vec2 v_diffVector;
varying float v_radius;
varying vec4 v_texture;
varying float v_textureIndex;

uniform sampler2D u_atlas[`.concat(n,`];
uniform float u_correctionRatio;
uniform float u_cameraAngle;
uniform float u_percentagePadding;
uniform bool u_colorizeImages;
uniform bool u_keepWithinCircle;

const vec4 transparent = vec4(0.0, 0.0, 0.0, 0.0);

const float radius = 0.5;

void main(void) {
  float border = 2.0 * u_correctionRatio;
  float dist = length(v_diffVector);
  vec4 color = gl_FragColor;

  float c = cos(-u_cameraAngle);
  float s = sin(-u_cameraAngle);
  vec2 diffVector = mat2(c, s, -s, c) * (v_diffVector);

  // No antialiasing for picking mode:
  #ifdef PICKING_MODE
  border = 0.0;
  color = v_color;

  #else
  // First case: No image to display
  if (v_texture.w <= 0.0) {
    if (!u_colorizeImages) {
      color = v_color;
    }
  }

  // Second case: Image loaded into the texture
  else {
    float paddingRatio = 1.0 + 2.0 * u_percentagePadding;
    float coef = u_keepWithinCircle ? 1.0 : `).concat(Math.SQRT2,`;
    vec2 coordinateInTexture = diffVector * vec2(paddingRatio, -paddingRatio) / v_radius / 2.0 * coef + vec2(0.5, 0.5);
    int index = int(v_textureIndex + 0.5); // +0.5 avoid rounding errors

    bool noTextureFound = false;
    vec4 texel;

    `).concat(xt(new Array(n)).map(function(e,t){return"if (index == ".concat(t,") texel = texture2D(u_atlas[").concat(t,"], (v_texture.xy + coordinateInTexture * v_texture.zw), -1.0);")}).join(`
    else `)+`else {
      texel = texture2D(u_atlas[0], (v_texture.xy + coordinateInTexture * v_texture.zw), -1.0);
      noTextureFound = true;
    }`,`

    if (noTextureFound) {
      color = v_color;
    } else {
      // Colorize all visible image pixels:
      if (u_colorizeImages) {
        color = mix(gl_FragColor, v_color, texel.a);
      }

      // Colorize background pixels, keep image pixel colors:
      else {
        color = vec4(mix(v_color, texel, texel.a).rgb, max(texel.a, v_color.a));
      }

      // Erase pixels "in the padding":
      if (abs(diffVector.x) > v_radius / paddingRatio || abs(diffVector.y) > v_radius / paddingRatio) {
        color = u_colorizeImages ? gl_FragColor : v_color;
      }
    }
  }
  #endif

  // Crop in a circle when u_keepWithinCircle is truthy:
  if (u_keepWithinCircle) {
    if (dist < v_radius - border) {
      gl_FragColor = color;
    } else if (dist < v_radius) {
      gl_FragColor = mix(transparent, color, (v_radius - dist) / border);
    }
  }

  // Crop in a square else:
  else {
    float squareHalfSize = v_radius * `).concat(Math.SQRT1_2*Math.cos(Math.PI/12),`;
    if (abs(diffVector.x) > squareHalfSize || abs(diffVector.y) > squareHalfSize) {
      gl_FragColor = transparent;
    } else {
      gl_FragColor = color;
    }
  }
}
`);return r}var _n=`
attribute vec4 a_id;
attribute vec4 a_color;
attribute vec2 a_position;
attribute float a_size;
attribute float a_angle;
attribute vec4 a_texture;
attribute float a_textureIndex;

uniform mat3 u_matrix;
uniform float u_sizeRatio;
uniform float u_correctionRatio;

varying vec4 v_color;
varying vec2 v_diffVector;
varying float v_radius;
varying vec4 v_texture;
varying float v_textureIndex;

const float bias = 255.0 / 254.0;
const float marginRatio = 1.05;

void main() {
  float size = a_size * u_correctionRatio / u_sizeRatio * 4.0;
  vec2 diffVector = size * vec2(cos(a_angle), sin(a_angle));
  vec2 position = a_position + diffVector * marginRatio;
  gl_Position = vec4(
    (u_matrix * vec3(position, 1)).xy,
    0,
    1
  );

  v_diffVector = diffVector;
  v_radius = size / 2.0 / marginRatio;

  #ifdef PICKING_MODE
  // For picking mode, we use the ID as the color:
  v_color = a_id;
  #else
  // For normal mode, we use the color:
  v_color = a_color;

  // Pass the texture coordinates:
  v_textureIndex = a_textureIndex;
  v_texture = a_texture;
  #endif

  v_color.a *= bias;
}
`,Tn=_n;function de(){de=function(){return n};var i,n={},r=Object.prototype,e=r.hasOwnProperty,t=Object.defineProperty||function(p,y,x){p[y]=x.value},a=typeof Symbol=="function"?Symbol:{},o=a.iterator||"@@iterator",s=a.asyncIterator||"@@asyncIterator",l=a.toStringTag||"@@toStringTag";function u(p,y,x){return Object.defineProperty(p,y,{value:x,enumerable:!0,configurable:!0,writable:!0}),p[y]}try{u({},"")}catch{u=function(y,x,A){return y[x]=A}}function h(p,y,x,A){var w=y&&y.prototype instanceof _?y:_,k=Object.create(w.prototype),O=new M(A||[]);return t(k,"_invoke",{value:N(p,x,O)}),k}function c(p,y,x){try{return{type:"normal",arg:p.call(y,x)}}catch(A){return{type:"throw",arg:A}}}n.wrap=h;var f="suspendedStart",v="suspendedYield",T="executing",b="completed",R={};function _(){}function g(){}function d(){}var E={};u(E,o,function(){return this});var P=Object.getPrototypeOf,L=P&&P(P(W([])));L&&L!==r&&e.call(L,o)&&(E=L);var C=d.prototype=_.prototype=Object.create(E);function I(p){["next","throw","return"].forEach(function(y){u(p,y,function(x){return this._invoke(y,x)})})}function D(p,y){function x(w,k,O,F){var X=c(p[w],p,k);if(X.type!=="throw"){var J=X.arg,Ee=J.value;return Ee&&typeof Ee=="object"&&e.call(Ee,"__await")?y.resolve(Ee.__await).then(function(se){x("next",se,O,F)},function(se){x("throw",se,O,F)}):y.resolve(Ee).then(function(se){J.value=se,O(J)},function(se){return x("throw",se,O,F)})}F(X.arg)}var A;t(this,"_invoke",{value:function(w,k){function O(){return new y(function(F,X){x(w,k,F,X)})}return A=A?A.then(O,O):O()}})}function N(p,y,x){var A=f;return function(w,k){if(A===T)throw Error("Generator is already running");if(A===b){if(w==="throw")throw k;return{value:i,done:!0}}for(x.method=w,x.arg=k;;){var O=x.delegate;if(O){var F=B(O,x);if(F){if(F===R)continue;return F}}if(x.method==="next")x.sent=x._sent=x.arg;else if(x.method==="throw"){if(A===f)throw A=b,x.arg;x.dispatchException(x.arg)}else x.method==="return"&&x.abrupt("return",x.arg);A=T;var X=c(p,y,x);if(X.type==="normal"){if(A=x.done?b:v,X.arg===R)continue;return{value:X.arg,done:x.done}}X.type==="throw"&&(A=b,x.method="throw",x.arg=X.arg)}}}function B(p,y){var x=y.method,A=p.iterator[x];if(A===i)return y.delegate=null,x==="throw"&&p.iterator.return&&(y.method="return",y.arg=i,B(p,y),y.method==="throw")||x!=="return"&&(y.method="throw",y.arg=new TypeError("The iterator does not provide a '"+x+"' method")),R;var w=c(A,p.iterator,y.arg);if(w.type==="throw")return y.method="throw",y.arg=w.arg,y.delegate=null,R;var k=w.arg;return k?k.done?(y[p.resultName]=k.value,y.next=p.nextLoc,y.method!=="return"&&(y.method="next",y.arg=i),y.delegate=null,R):k:(y.method="throw",y.arg=new TypeError("iterator result is not an object"),y.delegate=null,R)}function U(p){var y={tryLoc:p[0]};1 in p&&(y.catchLoc=p[1]),2 in p&&(y.finallyLoc=p[2],y.afterLoc=p[3]),this.tryEntries.push(y)}function Y(p){var y=p.completion||{};y.type="normal",delete y.arg,p.completion=y}function M(p){this.tryEntries=[{tryLoc:"root"}],p.forEach(U,this),this.reset(!0)}function W(p){if(p||p===""){var y=p[o];if(y)return y.call(p);if(typeof p.next=="function")return p;if(!isNaN(p.length)){var x=-1,A=function w(){for(;++x<p.length;)if(e.call(p,x))return w.value=p[x],w.done=!1,w;return w.value=i,w.done=!0,w};return A.next=A}}throw new TypeError(typeof p+" is not iterable")}return g.prototype=d,t(C,"constructor",{value:d,configurable:!0}),t(d,"constructor",{value:g,configurable:!0}),g.displayName=u(d,l,"GeneratorFunction"),n.isGeneratorFunction=function(p){var y=typeof p=="function"&&p.constructor;return!!y&&(y===g||(y.displayName||y.name)==="GeneratorFunction")},n.mark=function(p){return Object.setPrototypeOf?Object.setPrototypeOf(p,d):(p.__proto__=d,u(p,l,"GeneratorFunction")),p.prototype=Object.create(C),p},n.awrap=function(p){return{__await:p}},I(D.prototype),u(D.prototype,s,function(){return this}),n.AsyncIterator=D,n.async=function(p,y,x,A,w){w===void 0&&(w=Promise);var k=new D(h(p,y,x,A),w);return n.isGeneratorFunction(y)?k:k.next().then(function(O){return O.done?O.value:k.next()})},I(C),u(C,l,"Generator"),u(C,o,function(){return this}),u(C,"toString",function(){return"[object Generator]"}),n.keys=function(p){var y=Object(p),x=[];for(var A in y)x.push(A);return x.reverse(),function w(){for(;x.length;){var k=x.pop();if(k in y)return w.value=k,w.done=!1,w}return w.done=!0,w}},n.values=W,M.prototype={constructor:M,reset:function(p){if(this.prev=0,this.next=0,this.sent=this._sent=i,this.done=!1,this.delegate=null,this.method="next",this.arg=i,this.tryEntries.forEach(Y),!p)for(var y in this)y.charAt(0)==="t"&&e.call(this,y)&&!isNaN(+y.slice(1))&&(this[y]=i)},stop:function(){this.done=!0;var p=this.tryEntries[0].completion;if(p.type==="throw")throw p.arg;return this.rval},dispatchException:function(p){if(this.done)throw p;var y=this;function x(X,J){return k.type="throw",k.arg=p,y.next=X,J&&(y.method="next",y.arg=i),!!J}for(var A=this.tryEntries.length-1;A>=0;--A){var w=this.tryEntries[A],k=w.completion;if(w.tryLoc==="root")return x("end");if(w.tryLoc<=this.prev){var O=e.call(w,"catchLoc"),F=e.call(w,"finallyLoc");if(O&&F){if(this.prev<w.catchLoc)return x(w.catchLoc,!0);if(this.prev<w.finallyLoc)return x(w.finallyLoc)}else if(O){if(this.prev<w.catchLoc)return x(w.catchLoc,!0)}else{if(!F)throw Error("try statement without catch or finally");if(this.prev<w.finallyLoc)return x(w.finallyLoc)}}}},abrupt:function(p,y){for(var x=this.tryEntries.length-1;x>=0;--x){var A=this.tryEntries[x];if(A.tryLoc<=this.prev&&e.call(A,"finallyLoc")&&this.prev<A.finallyLoc){var w=A;break}}w&&(p==="break"||p==="continue")&&w.tryLoc<=y&&y<=w.finallyLoc&&(w=null);var k=w?w.completion:{};return k.type=p,k.arg=y,w?(this.method="next",this.next=w.finallyLoc,R):this.complete(k)},complete:function(p,y){if(p.type==="throw")throw p.arg;return p.type==="break"||p.type==="continue"?this.next=p.arg:p.type==="return"?(this.rval=this.arg=p.arg,this.method="return",this.next="end"):p.type==="normal"&&y&&(this.next=y),R},finish:function(p){for(var y=this.tryEntries.length-1;y>=0;--y){var x=this.tryEntries[y];if(x.finallyLoc===p)return this.complete(x.completion,x.afterLoc),Y(x),R}},catch:function(p){for(var y=this.tryEntries.length-1;y>=0;--y){var x=this.tryEntries[y];if(x.tryLoc===p){var A=x.completion;if(A.type==="throw"){var w=A.arg;Y(x)}return w}}throw Error("illegal catch attempt")},delegateYield:function(p,y,x){return this.delegate={iterator:W(p),resultName:y,nextLoc:x},this.method==="next"&&(this.arg=i),R}},n}function zr(i,n,r,e,t,a,o){try{var s=i[a](o),l=s.value}catch(u){return void r(u)}s.done?n(l):Promise.resolve(l).then(e,t)}function wt(i){return function(){var n=this,r=arguments;return new Promise(function(e,t){var a=i.apply(n,r);function o(l){zr(a,e,t,o,s,"next",l)}function s(l){zr(a,e,t,o,s,"throw",l)}o(void 0)})}}var At={size:{mode:"max",value:512},objectFit:"cover",correctCentering:!1,maxTextureSize:4096,debounceTimeout:500,crossOrigin:"anonymous"},Rn=1;function _t(i){var n=arguments.length>1&&arguments[1]!==void 0?arguments[1]:{},r=n.crossOrigin;return new Promise(function(e,t){var a=new Image;a.addEventListener("load",function(){e(a)},{once:!0}),a.addEventListener("error",function(o){t(o.error)},{once:!0}),r&&a.setAttribute("crossOrigin",r),a.src=i})}function xn(i){return Tt.apply(this,arguments)}function Tt(){return Tt=wt(de().mark(function i(n){var r,e,t,a,o,s,l,u,h,c,f,v,T,b=arguments;return de().wrap(function(_){for(;;)switch(_.prev=_.next){case 0:if(r=b.length>1&&b[1]!==void 0?b[1]:{},e=r.size,t=r.crossOrigin,t!=="use-credentials"){_.next=7;break}return _.next=4,fetch(n,{credentials:"include"});case 4:a=_.sent,_.next=10;break;case 7:return _.next=9,fetch(n);case 9:a=_.sent;case 10:return _.next=12,a.text();case 12:if(o=_.sent,s=new DOMParser().parseFromString(o,"image/svg+xml"),l=s.documentElement,u=l.getAttribute("width"),h=l.getAttribute("height"),!(!u||!h)){_.next=19;break}throw new Error("loadSVGImage: cannot use `size` if target SVG has no definite dimensions.");case 19:return typeof e=="number"&&(l.setAttribute("width",""+e),l.setAttribute("height",""+e)),c=new XMLSerializer().serializeToString(s),f=new Blob([c],{type:"image/svg+xml"}),v=URL.createObjectURL(f),T=_t(v),T.finally(function(){return URL.revokeObjectURL(v)}),_.abrupt("return",T);case 26:case"end":return _.stop()}},i)})),Tt.apply(this,arguments)}function Cn(i){return Rt.apply(this,arguments)}function Rt(){return Rt=wt(de().mark(function i(n){var r,e,t,a,o,s,l=arguments;return de().wrap(function(h){for(;;)switch(h.prev=h.next){case 0:if(e=l.length>1&&l[1]!==void 0?l[1]:{},t=e.size,a=e.crossOrigin,o=((r=n.split(/[#?]/)[0].split(".").pop())===null||r===void 0?void 0:r.trim().toLowerCase())==="svg",!(o&&t)){h.next=16;break}return h.prev=3,h.next=6,xn(n,{size:t,crossOrigin:a});case 6:s=h.sent,h.next=14;break;case 9:return h.prev=9,h.t0=h.catch(3),h.next=13,_t(n,{crossOrigin:a});case 13:s=h.sent;case 14:h.next=19;break;case 16:return h.next=18,_t(n,{crossOrigin:a});case 18:s=h.sent;case 19:return h.abrupt("return",s);case 20:case"end":return h.stop()}},i,null,[[3,9]])})),Rt.apply(this,arguments)}function Sn(i,n,r){var e=r.objectFit,t=r.size,a=r.correctCentering,o=e==="contain"?Math.max(i.width,i.height):Math.min(i.width,i.height),s=t.mode==="auto"?o:t.mode==="force"?t.value:Math.min(t.value,o),l=(i.width-o)/2,u=(i.height-o)/2;if(a){var h=n.getCorrectionOffset(i,o);l=h.x,u=h.y}return{sourceX:l,sourceY:u,sourceSize:o,destinationSize:s}}function wn(i,n,r){for(var e=n.canvas,t=e.width,a=e.height,o=[],s=r.x,l=r.y,u=r.rowHeight,h=r.maxRowWidth,c={},f=0,v=i.length;f<v;f++){var T=i[f],b=T.key,R=T.image,_=T.sourceSize,g=T.sourceX,d=T.sourceY,E=T.destinationSize,P=E+Rn;l+P>a||s+P>t&&l+P+u>a||(s+P>t&&(h=Math.max(h,s),s=0,l+=u,u=P),o.push({key:b,image:R,sourceX:g,sourceY:d,sourceSize:_,destinationX:s,destinationY:l,destinationSize:E}),c[b]={x:s,y:l,size:E},s+=P,u=Math.max(u,P))}h=Math.max(h,s);for(var L=h,C=l+u,I=0,D=o.length;I<D;I++){var N=o[I],B=N.image,U=N.sourceSize,Y=N.sourceX,M=N.sourceY,W=N.destinationSize,p=N.destinationX,y=N.destinationY;n.drawImage(B,Y,M,U,U,p,y,W,W)}return{atlas:c,texture:n.getImageData(0,0,L,C),cursor:{x:s,y:l,rowHeight:u,maxRowWidth:h}}}function An(i,n,r){var e=i.atlas,t=i.textures,a=i.cursor,o={atlas:Z({},e),textures:xt(t.slice(0,-1)),cursor:Z({},a)},s=[];for(var l in n){var u,h=n[l];if(h.status==="ready"){var c=(u=e[l])===null||u===void 0?void 0:u.textureIndex;typeof c!="number"&&s.push(Z({key:l},h))}}for(var f=function(){var T=wn(s,r,o.cursor),b=T.atlas,R=T.texture,_=T.cursor;o.cursor=_;var g=[];s.forEach(function(d){b[d.key]?o.atlas[d.key]=Z(Z({},b[d.key]),{},{textureIndex:o.textures.length}):g.push(d)}),o.textures.push(R),s=g,s.length&&(o.cursor={x:0,y:0,rowHeight:0,maxRowWidth:0},r.clearRect(0,0,r.canvas.width,r.canvas.height))};s.length;)f();return o}var Ln=(function(){function i(){Ct(this,i),this.canvas=document.createElement("canvas"),this.context=this.canvas.getContext("2d",{willReadFrequently:!0})}return St(i,[{key:"getCorrectionOffset",value:function(r,e){this.canvas.width=e,this.canvas.height=e,this.context.clearRect(0,0,e,e),this.context.drawImage(r,0,0,e,e);for(var t=this.context.getImageData(0,0,e,e).data,a=new Uint8ClampedArray(t.length/4),o=0;o<t.length;o++)a[o]=t[o*4+3];for(var s=0,l=0,u=0,h=0;h<e;h++)for(var c=0;c<e;c++){var f=a[h*e+c];u+=f,s+=f*c,l+=f*h}var v=s/u,T=l/u;return{x:v-e/2,y:T-e/2}}}]),i})(),Ye=(function(i){Wr(n,i);function n(){var r,e=arguments.length>0&&arguments[0]!==void 0?arguments[0]:{};return Ct(this,n),r=Vr(this,n),j(Q(r),"canvas",document.createElement("canvas")),j(Q(r),"ctx",r.canvas.getContext("2d",{willReadFrequently:!0})),j(Q(r),"corrector",new Ln),j(Q(r),"imageStates",{}),j(Q(r),"textures",[r.ctx.getImageData(0,0,1,1)]),j(Q(r),"lastTextureCursor",{x:0,y:0,rowHeight:0,maxRowWidth:0}),j(Q(r),"atlas",{}),r.options=Z(Z({},At),e),r.canvas.width=r.options.maxTextureSize,r.canvas.height=r.options.maxTextureSize,r}return St(n,[{key:"scheduleGenerateTexture",value:function(){var e=this;typeof this.frameId!="number"&&(typeof this.options.debounceTimeout=="number"?this.frameId=window.setTimeout(function(){e.generateTextures(),e.frameId=void 0},this.options.debounceTimeout):this.generateTextures())}},{key:"generateTextures",value:function(){var e=An({atlas:this.atlas,textures:this.textures,cursor:this.lastTextureCursor},this.imageStates,this.ctx),t=e.atlas,a=e.textures,o=e.cursor;this.atlas=t,this.textures=a,this.lastTextureCursor=o,this.emit(n.NEW_TEXTURE_EVENT,{atlas:t,textures:a})}},{key:"registerImage",value:(function(){var r=wt(de().mark(function t(a){var o,s;return de().wrap(function(u){for(;;)switch(u.prev=u.next){case 0:if(!this.imageStates[a]){u.next=2;break}return u.abrupt("return");case 2:return this.imageStates[a]={status:"loading"},u.prev=3,o=this.options.size,u.next=7,Cn(a,{size:o.mode==="force"?o.value:void 0,crossOrigin:this.options.crossOrigin||void 0});case 7:s=u.sent,this.imageStates[a]=Z({status:"ready",image:s},Sn(s,this.corrector,this.options)),this.scheduleGenerateTexture(),u.next=15;break;case 12:u.prev=12,u.t0=u.catch(3),this.imageStates[a]={status:"error"};case 15:case"end":return u.stop()}},t,this,[[3,12]])}));function e(t){return r.apply(this,arguments)}return e})()},{key:"getAtlas",value:function(){return this.atlas}},{key:"getTextures",value:function(){return this.textures}}]),n})(Ur.EventEmitter);j(Ye,"NEW_TEXTURE_EVENT","newTexture");var Pn=["drawHover","drawLabel","drawingMode","keepWithinCircle","padding","colorAttribute","imageAttribute"],jr=WebGLRenderingContext,Mr=jr.UNSIGNED_BYTE,Se=jr.FLOAT,kn=Z(Z({},At),{},{drawingMode:"background",keepWithinCircle:!0,drawLabel:void 0,drawHover:void 0,padding:0,colorAttribute:"color",imageAttribute:"image"}),Nn=["u_sizeRatio","u_correctionRatio","u_cameraAngle","u_percentagePadding","u_matrix","u_colorizeImages","u_keepWithinCircle","u_atlas"];function qe(i){var n,r=document.createElement("canvas").getContext("webgl"),e=Math.min(r.getParameter(r.MAX_TEXTURE_SIZE),At.maxTextureSize);r.canvas.remove();var t=Z(Z(Z({},kn),{maxTextureSize:e}),i||{}),a=t.drawHover,o=t.drawLabel,s=t.drawingMode,l=t.keepWithinCircle,u=t.padding,h=t.colorAttribute,c=t.imageAttribute,f=yn(t,Pn),v=new Ye(f);return n=(function(T){Wr(b,T);function b(R,_,g){var d;return Ct(this,b),d=Vr(this,b,[R,_,g]),j(Q(d),"drawLabel",o),j(Q(d),"drawHover",a),j(Q(d),"textureManagerCallback",null),d.textureManagerCallback=function(E){var P=E.atlas,L=E.textures,C=L.length!==d.textures.length;d.atlas=P,d.textureImages=L,C&&d.upgradeShaders(),d.bindTextures(),d.latestRenderParams&&d.render(d.latestRenderParams),d.renderer&&d.renderer.refresh&&d.renderer.refresh()},v.on(Ye.NEW_TEXTURE_EVENT,d.textureManagerCallback),d.atlas=v.getAtlas(),d.textureImages=v.getTextures(),d.textures=d.textureImages.map(function(){return R.createTexture()}),d.bindTextures(),d}return St(b,[{key:"getDefinition",value:function(){return{VERTICES:3,VERTEX_SHADER_SOURCE:Tn,FRAGMENT_SHADER_SOURCE:En({texturesCount:v.getTextures().length}),METHOD:WebGLRenderingContext.TRIANGLES,UNIFORMS:Nn,ATTRIBUTES:[{name:"a_position",size:2,type:Se},{name:"a_size",size:1,type:Se},{name:"a_color",size:4,type:Mr,normalized:!0},{name:"a_id",size:4,type:Mr,normalized:!0},{name:"a_texture",size:4,type:Se},{name:"a_textureIndex",size:1,type:Se}],CONSTANT_ATTRIBUTES:[{name:"a_angle",size:1,type:Se}],CONSTANT_DATA:[[b.ANGLE_1],[b.ANGLE_2],[b.ANGLE_3]]}}},{key:"upgradeShaders",value:function(){var _=this.getDefinition(),g=this.normalProgram,d=g.program,E=g.buffer,P=g.vertexShader,L=g.fragmentShader,C=g.gl;C.deleteProgram(d),C.deleteBuffer(E),C.deleteShader(P),C.deleteShader(L),this.normalProgram=this.getProgramInfo("normal",C,_.VERTEX_SHADER_SOURCE,_.FRAGMENT_SHADER_SOURCE,null)}},{key:"kill",value:function(){var _,g=(_=this.normalProgram)===null||_===void 0?void 0:_.gl;if(g)for(var d=0;d<this.textures.length;d++)g.deleteTexture(this.textures[d]);this.textureManagerCallback&&(v.off(Ye.NEW_TEXTURE_EVENT,this.textureManagerCallback),this.textureManagerCallback=null),Or(b,"kill",this,3)([])}},{key:"bindTextures",value:function(){for(var _=this.normalProgram.gl,g=0;g<this.textureImages.length;g++){if(g>=this.textures.length){var d=_.createTexture();d&&this.textures.push(d)}_.activeTexture(_.TEXTURE0+g),_.bindTexture(_.TEXTURE_2D,this.textures[g]),_.texImage2D(_.TEXTURE_2D,0,_.RGBA,_.RGBA,_.UNSIGNED_BYTE,this.textureImages[g]),_.generateMipmap(_.TEXTURE_2D)}}},{key:"renderProgram",value:function(_,g){if(!g.isPicking)for(var d=g.gl,E=0;E<this.textureImages.length;E++)d.activeTexture(d.TEXTURE0+E),d.bindTexture(d.TEXTURE_2D,this.textures[E]);Or(b,"renderProgram",this,3)([_,g])}},{key:"processVisibleItem",value:function(_,g,d){var E=this.array,P=q(d[h]),L=d[c],C=L?this.atlas[L]:void 0;if(typeof L=="string"&&!C&&v.registerImage(L),E[g++]=d.x,E[g++]=d.y,E[g++]=d.size,E[g++]=P,E[g++]=_,C&&typeof C.textureIndex=="number"){var I=this.textureImages[C.textureIndex],D=I.width,N=I.height;E[g++]=C.x/D,E[g++]=C.y/N,E[g++]=C.size/D,E[g++]=C.size/N,E[g++]=C.textureIndex}else E[g++]=0,E[g++]=0,E[g++]=0,E[g++]=0,E[g++]=0}},{key:"setUniforms",value:function(_,g){var d=g.gl,E=g.uniformLocations,P=E.u_sizeRatio,L=E.u_correctionRatio,C=E.u_matrix,I=E.u_atlas,D=E.u_colorizeImages,N=E.u_keepWithinCircle,B=E.u_cameraAngle,U=E.u_percentagePadding;this.latestRenderParams=_,d.uniform1f(L,_.correctionRatio),d.uniform1f(P,l?_.sizeRatio:_.sizeRatio/Math.SQRT2),d.uniform1f(B,_.cameraAngle),d.uniform1f(U,u),d.uniformMatrix3fv(C,!1,_.matrix),d.uniform1iv(I,xt(new Array(this.textureImages.length)).map(function(Y,M){return M})),d.uniform1i(D,s==="color"?1:0),d.uniform1i(N,l?1:0)}}]),b})(ve),j(n,"ANGLE_1",0),j(n,"ANGLE_2",2*Math.PI/3),j(n,"ANGLE_3",4*Math.PI/3),j(n,"textureManager",v),n}var za=qe(),Ma=qe({keepWithinCircle:!1,size:{mode:"force",value:256},drawingMode:"color",correctCentering:!0});var Dn=300,Fn=2e3,In=500,On=700,Xr=3,Gn=16;function zn(i,n,{surfaces:r}){if(r.length>Dn)return()=>{};let e=(a,o)=>i.mergeNodeAttributes(a,{type:"image",image:o});if(!Pt()){for(let{id:a,reference:o}of r)e(a,Nt($e(n,o)));return()=>{}}let t=r.map(({id:a,reference:o})=>{let{value:s,release:l}=kt($e(n,o));return s.then(u=>e(a,u),()=>{}),l});return()=>t.forEach(a=>a())}function Mn({surfaces:i,edges:n},r){let e=new It({type:"undirected"}),t=i.reduce((o,{features:s})=>Math.max(o,s),1),a=Math.min(1,Math.sqrt(In/i.length))*Math.min(1,r/On);i.forEach(({id:o,features:s},l)=>{let u=2*Math.PI*l/i.length;e.addNode(o,{x:Math.cos(u),y:Math.sin(u),size:a*(Xr+(Gn-Xr)*Math.sqrt(s/t)),color:Dt(o),label:`surface ${o}`,type:"circle"})});for(let[o,s]of n)e.mergeEdge(o,s,{size:a});return e}function Un(i,{surfaces:n,edges:r},e){let t=new Map(n.map(({id:s},l)=>[s,l])),a=r.flatMap(([s,l])=>[t.get(s),t.get(l)]),o=new Worker("/page/layout_worker.js",{type:"module"});return o.onmessage=({data:s})=>{if(!s)return e();i.updateEachNodeAttributes((l,u)=>{let h=t.get(Number(l));return{...u,x:s[2*h],y:s[2*h+1]}},{attributes:["x","y"]})},o.postMessage({nodes:n.length,edges:Uint32Array.from(a)}),()=>o.terminate()}var Bn=(i,n,r)=>{let e=n.label??"";i.font=`600 ${r.labelSize}px ${r.labelFont}`;let t=n.x+n.size+3;i.fillStyle=ie("--ground"),i.fillRect(t-2,n.y-r.labelSize,i.measureText(e).width+4,1.8*r.labelSize),i.fillStyle=ie("--text"),i.fillText(e,t,n.y+r.labelSize/3),i.beginPath(),i.arc(n.x,n.y,n.size+2,0,2*Math.PI),i.strokeStyle=ie("--accent"),i.lineWidth=3,i.stroke()};function Hn(i,n){let r=i.order>=Fn;return new Rr(i,n,{allowInvalidContainer:!0,hideEdgesOnMove:r,hideLabelsOnMove:r,edgeProgramClasses:r?{line:Dr}:{},nodeProgramClasses:{...r?{circle:Lr}:{},image:qe({padding:.12,keepWithinCircle:!0,size:{mode:"max",value:128}})},defaultEdgeColor:ie("--line"),labelColor:{color:ie("--text")},labelFont:"system-ui, sans-serif",labelSize:12,labelRenderedSizeThreshold:9,labelDensity:.6,zIndex:!0,defaultDrawNodeHover:Bn})}function Vn(i,n,r){let e=t=>{let a=r();return a!==null&&(t===a||n.areNeighbors(t,a))};i.setSetting("nodeReducer",(t,a)=>{let o=r();return o===null?a:t===o?{...a,highlighted:!0,forceLabel:!0,zIndex:2}:e(t)?{...a,forceLabel:!0,zIndex:1}:{...a,color:ie("--line"),label:"",type:"circle"}}),i.setSetting("edgeReducer",(t,a)=>{let o=r();return o===null||!n.hasExtremity(t,o)?a:{...a,color:ie("--accent"),size:2}})}function Za(i){let{map:n,surfaces:r,selected:e,select:t}=i,a=we(null),o=we(null),s=we(null),[l,u]=Lt("moving"),h=Ft("(prefers-color-scheme: dark)");Ze(()=>{let f=Mn(r,a.current.clientWidth),v=zn(f,n,r);u("moving");let T=Un(f,r,()=>u("settled")),b=Hn(f,a.current);return Vn(b,f,()=>s.current),b.on("clickNode",({node:R})=>t(Number(R))),o.current=b,()=>{T(),b.kill(),v(),o.current=null}},[n,r,h]),Ze(()=>{let f=e===null?void 0:r.ofPlane.get(e);s.current=f===void 0?null:String(f),o.current?.refresh({skipIndexation:!0})},[e,r,h]);let c=()=>o.current?.getCamera();return ne("div",{class:"graph","data-state":l,children:[ne("div",{class:"canvas",ref:a,role:"img","aria-label":"Graph of surfaces. The table of planes has the same information."}),ne("div",{class:"tools",children:[ne("button",{"aria-label":"Zoom in",onClick:()=>c()?.animatedZoom(),children:"+"}),ne("button",{"aria-label":"Zoom out",onClick:()=>c()?.animatedUnzoom(),children:"\u2212"}),ne("button",{onClick:()=>c()?.animatedReset(),children:"Fit"})]})]})}export{Za as PlaneGraph};
