// SPDX-License-Identifier: Apache-2.0
#include "core/base/text.h"

#include <gtest/gtest.h>

namespace waystone {
namespace {

TEST(EscapeHtml, LeavesNothingThatAPageWouldTakeForItsOwn) {
  EXPECT_EQ(EscapeHtml("<img src=x onerror=\"a('b')\"> & co"),
            "&lt;img src=x onerror=&quot;a(&#39;b&#39;)&quot;&gt; &amp; co");
}

TEST(EscapeHtml, LeavesPlainTextAlone) {
  EXPECT_EQ(EscapeHtml(""), "");
  const std::string plain =
      "K\xc3\xbc"
      "che 1/2 #3; 50 %\n";
  EXPECT_EQ(EscapeHtml(plain), plain);
}

TEST(EscapeHtml, EscapesWhatIsEscapedAgain) {
  EXPECT_EQ(EscapeHtml("&lt;"), "&amp;lt;") << "text is shown as it is";
}

TEST(Printable, ShowsControlCharactersOnOneLine) {
  EXPECT_EQ(Printable("a\tb\n\x1b[2J\r\x7f\x07"),
            "a\\u0009b\\u000a\\u001b[2J\\u000d\\u007f\\u0007");
  EXPECT_EQ(Printable("\u009b31m \u00a9 \xc2"), "\\u009b31m \u00a9 \xc2");
  EXPECT_EQ(Printable("Gar\u00e7on \u4f4d"), "Gar\u00e7on \u4f4d");
}

}  // namespace
}  // namespace waystone
