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

TEST(Printable, ShowsWhatTurnsTheTextAroundOrEndsALine) {
  EXPECT_EQ(Printable("\u202egpj.exe\u202c \u2066x\u2069 \u061c\u200e\u200f\u2028\u2029"),
            "\\u202egpj.exe\\u202c \\u2066x\\u2069 \\u061c\\u200e\\u200f\\u2028\\u2029");
  // Their neighbours, and what is cut off.
  const std::string plain = "\u2010\u201c\u2027\u202f\u2065\u206a\u061b\u00a0 \xe2\x80";
  EXPECT_EQ(Printable(plain), plain);
}

TEST(Trimmed, TakesTheEndsAlone) {
  EXPECT_EQ(Trimmed(" \ta b\r\n"), "a b");
  EXPECT_EQ(Trimmed("a\r", " \t"), "a\r");
  EXPECT_EQ(Trimmed(" \t "), "");
}

TEST(Words, ArePartedByAnyOfTheSeparators) {
  EXPECT_EQ(Words(" 1  b\t"), (std::vector<std::string>{"1", "b"}));
  EXPECT_EQ(Words("1, 2", ", "), (std::vector<std::string>{"1", "2"}));
  EXPECT_TRUE(Words("").empty());
}

TEST(ToNumber, IsAllOfTheWord) {
  EXPECT_EQ(ToNumber("-1.5e3"), -1500);
  EXPECT_EQ(ToNumber("+2"), 2);
  for (const char* word : {"", "+", "+-2", "1,5", "2 ", "0x1p2m", "two"}) {
    EXPECT_EQ(ToNumber(word), std::nullopt) << word;
  }
  EXPECT_EQ(ToInteger("12"), 12);
  EXPECT_EQ(ToInteger("1.5"), std::nullopt);
}

}  // namespace
}  // namespace waystone
