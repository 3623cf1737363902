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

}  // namespace
}  // namespace waystone
