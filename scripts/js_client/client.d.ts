
/** An image's bytes; a form with images in their order; or the JSON of a request with images. */
export type Photo = Blob | ArrayBuffer | ArrayBufferView | FormData |
  (Request & { images: { name?: string; data: string }[] });

export declare class WaystoneError extends Error {
  /** The contract's code, or "unreachable", "timeout" or "bad_answer". */
  code: string;
  /** Of HTTP; 0 where no answer came. */
  status: number;
  constructor(code: string, status: number, detail: string);
}

/** Runs in browsers and in Node 18 and later. Throws WaystoneError alone. */
export declare class Client {
  server: string;
  token: string | null;
  timeout_ms: number;
  retries: number;
  /**
   * `server` is an address without path, or "" in a page that the server gave; the token is printable
   * ASCII. Others are a "bad_request". `timeout_ms` may be Infinity, which waits for weeks.
   */
  constructor(server?: string, options?: { token?: string | null; timeout_ms?: number; retries?: number });
  /** One request, as all methods send it. An answer of another kind than `kind` is an error. */
  ask(verb: string, path: string, options?: object, photo?: Photo, kind?: "json" | "image" | "text" | null): Promise<unknown>;
  // ROWS
  // OPERATIONS
}
