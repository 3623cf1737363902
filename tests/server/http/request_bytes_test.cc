// SPDX-License-Identifier: Apache-2.0
// The bytes of a request: its head and the chunks of its body.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "server/http/chunked_body.h"
#include "server/http/request_head.h"

namespace waystone {
namespace {

const std::string kHead = "POST /a?b=c HTTP/1.1\r\nHost: x\r\nContent-Length: 7\r\n\r\n";

ErrorCode ScanError(const std::string& bytes) {
  HeadScanner scanner;
  try {
    scanner.Scan(bytes);
  } catch (const MapError& error) {
    return error.code();
  }
  return ErrorCode::kInternal;
}

TEST(HeadScanner, FindsTheEndWhereverTheBytesAreCut) {
  const std::string bytes = kHead + "body\r\n\r\n";
  for (size_t step = 1; step <= bytes.size(); ++step) {
    HeadScanner scanner;
    std::optional<size_t> size;
    for (size_t have = 0; have < bytes.size() && !size;) {
      have = std::min(bytes.size(), have + step);
      size = scanner.Scan(std::string_view(bytes).substr(0, have));
      EXPECT_EQ(size.has_value(), have >= kHead.size()) << step << ", " << have;
    }
    EXPECT_EQ(size, kHead.size()) << step;
  }
}

TEST(HeadScanner, HasBounds) {
  const std::string first = "GET / HTTP/1.1\r\n";
  const std::string longest(kMaxHeaderLineBytes - 4, 'x');
  EXPECT_EQ(ScanError("GET /" + std::string(kMaxRequestLineBytes, 'x')), ErrorCode::kHeadTooLarge);
  EXPECT_EQ(ScanError(first + "A: " + longest), ErrorCode::kInternal) << "not yet too long";
  EXPECT_EQ(ScanError(first + "A: " + longest + "xx"), ErrorCode::kHeadTooLarge);
  std::string many = first;
  for (int i = 0; i < kMaxHeaders; ++i) many += "A: b\r\n";
  EXPECT_EQ(ScanError(many + "\r\n"), ErrorCode::kInternal);
  EXPECT_EQ(ScanError(many + "A: b\r\n"), ErrorCode::kHeadTooLarge);
  std::string large = first;
  for (int i = 0; i < 20; ++i) large += "A: " + std::string(4000, 'x') + "\r\n";
  EXPECT_EQ(ScanError(large), ErrorCode::kHeadTooLarge);
  EXPECT_EQ(ScanError(first + std::string("A: \0b\r\n", 7)), ErrorCode::kBadRequest);
  EXPECT_EQ(ScanError("GET / HTTP/1.1\nA: b\r\n"), ErrorCode::kBadRequest);
}

TEST(RequestHead, TakesTheFramingOut) {
  const RequestHead head = ParseRequestHead(kHead);
  EXPECT_FALSE(head.refusal);
  EXPECT_TRUE(head.is_post);
  EXPECT_EQ(head.body_bytes, 7);
  EXPECT_EQ(head.text, "POST /a?b=c HTTP/1.1\r\nHost: x\r\n\r\n");
  const RequestHead chunked = ParseRequestHead(
      "POST / HTTP/1.1\r\nhost: x\r\ntransfer-encoding: Chunked\r\nEXPECT: 100-continue\r\n"
      "Authorization:  Bearer t \r\n\r\n");
  EXPECT_FALSE(chunked.refusal);
  EXPECT_TRUE(chunked.chunked && chunked.expects_continue && chunked.has_body());
  EXPECT_EQ(chunked.authorization, "Bearer t");
  EXPECT_EQ(chunked.text, "POST / HTTP/1.1\r\nhost: x\r\nAuthorization:  Bearer t \r\n\r\n");
  EXPECT_TRUE(ParseRequestHead("GET /healthz?x HTTP/1.1\r\n\r\n").is_urgent);
  EXPECT_FALSE(ParseRequestHead("GET /healthzz HTTP/1.1\r\n\r\n").is_urgent);
}

TEST(RequestHead, RefusesWhatCanBeReadInTwoWays) {
  for (const char* headers :
       {"Content-Length: 5\r\nContent-Length: 5", "Content-Length: +5", "Content-Length: 5,5",
        "Content-Length:", "Content-Length: 5\r\nTransfer-Encoding: chunked",
        "Transfer-Encoding: gzip, chunked",
        "Transfer-Encoding: chunked\r\nTransfer-Encoding: chunked", "Transfer-Encoding : chunked",
        "A: b\r\n folded: c", "no colon", ": no name", "Expect: the unexpected",
        "Content-Length: 5\r\nContent-Encoding: gzip", "Host: x", "hOST: y",
        "Transfer-Encoding\x0b: chunked", "A B: c"}) {
    const RequestHead head =
        ParseRequestHead("POST / HTTP/1.1\r\nHost: x\r\n" + std::string(headers) + "\r\n\r\n");
    EXPECT_TRUE(head.refusal) << headers;
  }
  for (const char* line : {"GET  HTTP/1.1", "GET /", " / HTTP/1.1", "GET / HTTP/2.0", "nonsense"}) {
    EXPECT_TRUE(ParseRequestHead(std::string(line) + "\r\nHost: x\r\n\r\n").refusal) << line;
  }
  EXPECT_TRUE(ParseRequestHead("GET / HTTP/1.1\r\nHost: x\r\nContent-Length: 1\r\n\r\n").refusal);
}

TEST(RequestHead, HeadersAreAsTheyCame) {
  const RequestHead head = ParseRequestHead(
      "GET / HTTP/1.1\r\nHost: x\r\nauthorization: Bearer a%41b\r\nA:\r\nRange: b\r\n\r\n");
  const std::vector<std::pair<std::string, std::string>> expected = {
      {"Host", "x"}, {"authorization", "Bearer a%41b"}, {"A", ""}};
  EXPECT_EQ(head.headers, expected);
}

TEST(RequestHead, ClosesWhereTheListOfTheConnectionSaysSo) {
  const auto closes = [](const std::string& value) {
    return ParseRequestHead("GET / HTTP/1.1\r\nHost: x\r\nConnection: " + value + "\r\n\r\n").close;
  };
  EXPECT_TRUE(closes("close") && closes("Close") && closes("TE , CLOSE") && closes("close, TE"));
  EXPECT_FALSE(closes("") || closes(",") || closes("keep-alive") || closes("closed, TE"));
}

// RFC 9112, section 9.3.
TEST(RequestHead, OlderClientsMustAskForTheConnectionToBeKept) {
  const auto closes = [](const std::string& headers) {
    return ParseRequestHead("GET / HTTP/1.0\r\n" + headers + "\r\n").close;
  };
  EXPECT_TRUE(closes("") && closes("Connection: TE\r\n") && closes("Keep-Alive: timeout=5\r\n"));
  EXPECT_TRUE(closes("Connection: keep-alive\r\nConnection: Close\r\n"));
  EXPECT_FALSE(closes("Connection: Keep-Alive\r\n") || closes("connection: keep-alive\r\n"));
  EXPECT_FALSE(closes("Connection: TE , KEEP-ALIVE\r\n"));
}

TEST(RequestHead, OlderClientsHaveNeitherCodingsNorExpectations) {
  const std::string line = "POST / HTTP/1.0\r\n";
  EXPECT_TRUE(ParseRequestHead(line + "Transfer-Encoding: chunked\r\n\r\n").refusal);
  const RequestHead head =
      ParseRequestHead(line + "Content-Length: 1\r\nExpect: 100-continue\r\n\r\n");
  EXPECT_FALSE(head.refusal || head.expects_continue) << "RFC 9110, section 10.1.1";
}

TEST(RequestHead, HasMethodTargetAndHost) {
  const auto read = [](const std::string& line) {
    return ParseRequestHead(line + " HTTP/1.1\r\nHost: x:1\r\nRange: nonsense\r\n\r\n");
  };
  const RequestHead head = read("get /a?b#c");
  EXPECT_FALSE(head.refusal);
  EXPECT_EQ(head.method + " " + head.target + " " + *head.host, "get /a?b#c x:1");
  EXPECT_EQ(head.text.find("Range"), std::string::npos);
  const RequestHead absolute = read("POST HTTP://127.0.0.1:80/v1/maps?x=http://y");
  EXPECT_EQ(absolute.target, "/v1/maps?x=http://y");
  EXPECT_EQ(absolute.host, "127.0.0.1:80") << "RFC 9112, section 3.2.2";
  EXPECT_EQ(read("GET https://y?x=1").target, "/?x=1");
  EXPECT_TRUE(read("GET http://x/healthz").is_urgent);
  EXPECT_EQ(read("OPTIONS *").target, "*");
  EXPECT_EQ(ParseRequestHead("GET / HTTP/1.1\r\nHost:\r\n\r\n").host, "");
  EXPECT_EQ(ParseRequestHead("GET / HTTP/1.0\r\n\r\n").host, std::nullopt);
  for (const char* line :
       {"GET *", "GET x", "GET http:///a", "GET http://", "GET ftp://x/a", "GET /a b", "GET  /a",
        "GET /a ", "GET /a\tb", "G(T /a", "CONNECT x:1", "GET a:/"}) {
    EXPECT_TRUE(read(line).refusal) << line;
  }
}

TEST(RequestHead, OneHostIsRequiredSinceHttp11) {
  EXPECT_TRUE(ParseRequestHead("GET / HTTP/1.1\r\n\r\n").refusal);
  EXPECT_FALSE(ParseRequestHead("GET / HTTP/1.1\r\nHost: x\r\n\r\n").refusal);
  EXPECT_FALSE(ParseRequestHead("GET / HTTP/1.0\r\n\r\n").refusal);
  EXPECT_TRUE(ParseRequestHead("GET / HTTP/1.0\r\nHost: x\r\nHost: x\r\n\r\n").refusal);
}

TEST(ChunkedBody, IsTheSameWhereverItIsCut) {
  const std::string chunks =
      "5;ext=\"a;b\"\r\nabcde\r\n00A\r\n0123456789\r\n0\r\nTrailer: t\r\n\r\n";
  const std::string bytes = chunks + "GET /next";
  for (size_t step = 1; step <= bytes.size(); ++step) {
    ChunkedBody body;
    std::string text;
    size_t taken = 0;
    for (size_t at = 0; at < bytes.size() && !body.complete(); at += step) {
      taken += body.Take(std::string_view(bytes).substr(at, step), text);
    }
    EXPECT_TRUE(body.complete());
    EXPECT_EQ(text, "abcde0123456789") << step;
    EXPECT_EQ(taken, chunks.size()) << step;
  }
}

TEST(ChunkedBody, RefusesWhatIsNoChunk) {
  for (const std::string& bytes :
       {std::string("x\r\n"), std::string("-5\r\n"), std::string("\r\n"), std::string("5\n"),
        std::string("3\r\nabcd\r\n"), std::string("fffffffffffffffff\r\n"), std::string("0x5\r\n"),
        std::string(kMaxChunkLineBytes + 1, '1'), "5;" + std::string(kMaxChunkLineBytes, 'e')}) {
    ChunkedBody body;
    std::string text;
    EXPECT_THROW(body.Take(bytes, text), MapError) << bytes.substr(0, 20);
  }
  std::string trailers = "0\r\n";
  for (int i = 0; i <= kMaxTrailers; ++i) trailers += "A: b\r\n";
  ChunkedBody body;
  std::string text;
  EXPECT_THROW(body.Take(trailers, text), MapError);
}

}  // namespace
}  // namespace waystone
