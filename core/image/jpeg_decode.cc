// SPDX-License-Identifier: Apache-2.0
#include <csetjmp>
#include <cstdio>  // for jpeglib.h, which doesn't include it
#include <new>
#include <string>

// After <cstdio>.
#include <jerror.h>
#include <jpeglib.h>

#include "core/image/formats.h"

namespace waystone {
namespace {

// What libjpeg says goes here instead of to stderr.
struct JpegMessages {
  jpeg_error_mgr library;  // first: libjpeg knows of nothing else
  std::jmp_buf end;        // of the decoding
  int code = 0;            // of what ended it
};

[[noreturn]] void EndDecoding(j_common_ptr codec) {
  auto* messages = reinterpret_cast<JpegMessages*>(codec->err);
  messages->code = codec->err->msg_code;
  // NOLINTNEXTLINE(cert-err52-cpp): libjpeg is C, and nothing here has a destructor
  std::longjmp(messages->end, 1);
}

// Whether the pixels from here on are made up. Some cameras end the last row too early, and bytes
// between the data and its marker, of which libjpeg also warns, do no harm.
bool IsDamage(int code, const jpeg_decompress_struct& codec) {
  switch (code) {
    case JWRN_HIT_MARKER:
    case JWRN_HUFF_BAD_CODE:
      return codec.input_iMCU_row + 1 < codec.total_iMCU_rows;
    case JWRN_JPEG_EOF:
    case JWRN_MUST_RESYNC:
      return true;
    default:
      return false;
  }
}

void OnMessage(j_common_ptr codec, int level) {
  const bool warning = level < 0 && codec->is_decompressor != 0;
  if (!warning) return;
  if (IsDamage(codec->err->msg_code, *reinterpret_cast<j_decompress_ptr>(codec))) {
    EndDecoding(codec);
  }
}

class JpegDecoder {
 public:
  JpegDecoder() {
    codec_.err = jpeg_std_error(&messages_.library);
    messages_.library.error_exit = EndDecoding;
    messages_.library.emit_message = OnMessage;
    messages_.library.output_message = [](j_common_ptr) {};
  }
  ~JpegDecoder() { jpeg_destroy_decompress(&codec_); }
  JpegDecoder(const JpegDecoder&) = delete;
  JpegDecoder& operator=(const JpegDecoder&) = delete;

  // False for four colours, which are whole then and which OpenCV converts. Throws.
  bool Decode(Bytes bytes, cv::Mat& image) {
    const JpegResult result = Run(bytes, image);
    if (result != JpegResult::kFailed) return result == JpegResult::kDone;
    if (messages_.code == JERR_OUT_OF_MEMORY) throw std::bad_alloc();
    RefuseImage("the jpeg of " + std::to_string(bytes.size()) + " bytes is damaged: " + Cause() +
                "; copy or send the file again");
  }

 private:
  enum class JpegResult { kDone, kOtherColours, kFailed };

  // libjpeg returns by longjmp on errors, so nothing in this frame may need a destructor.
  JpegResult Run(Bytes bytes, cv::Mat& image) {
    // NOLINTNEXTLINE(cert-err52-cpp)
    if (setjmp(messages_.end) != 0) return JpegResult::kFailed;
    jpeg_create_decompress(&codec_);
    jpeg_mem_src(&codec_, bytes.data(), bytes.size());
    jpeg_read_header(&codec_, TRUE);
    const bool four = codec_.num_components == 4;
    codec_.out_color_space = four ? JCS_CMYK : image.channels() == 3 ? JCS_EXT_BGR : JCS_GRAYSCALE;
    jpeg_start_decompress(&codec_);
    if (static_cast<int>(codec_.output_width) != image.cols ||
        static_cast<int>(codec_.output_height) != image.rows) {
      return JpegResult::kFailed;
    }
    JSAMPROW cmyk = four ? AllocateRow() : nullptr;
    while (codec_.output_scanline < codec_.output_height) {
      JSAMPROW row = four ? cmyk : image.ptr(static_cast<int>(codec_.output_scanline));
      jpeg_read_scanlines(&codec_, &row, 1);
    }
    jpeg_finish_decompress(&codec_);
    return four ? JpegResult::kOtherColours : JpegResult::kDone;
  }

  // Of four colours; libjpeg frees it.
  JSAMPROW AllocateRow() {
    return *codec_.mem->alloc_sarray(reinterpret_cast<j_common_ptr>(&codec_), JPOOL_IMAGE,
                                     4 * codec_.output_width, 1);
  }

  std::string Cause() const {
    switch (messages_.code) {
      case JWRN_HIT_MARKER:
      case JWRN_JPEG_EOF:
        return "its image data ends too early";
      case JWRN_HUFF_BAD_CODE:
      case JWRN_MUST_RESYNC:
        return "its image data has bytes that mean nothing";
      default:
        return "its pixels can't be decoded";
    }
  }

  jpeg_decompress_struct codec_ = {};
  JpegMessages messages_ = {};
};

}  // namespace

bool DecodeJpeg(Bytes bytes, cv::Mat& image) { return JpegDecoder().Decode(bytes, image); }

}  // namespace waystone
