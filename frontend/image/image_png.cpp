// SPDX-License-Identifier: Apache-2.0
// 8-bit RGB PNG through libpng. libpng reports errors by longjmp, so every call runs in a function whose frame owns
// nothing that needs a destructor.
#include <fmt/format.h>
#include <png.h>

#include <csetjmp>
#include <cstring>
#include <new>
#include <vector>

#include "grtx/base/colour_byte.h"
#include "grtx/base/error.h"
#include "grtx/frontend/image/image_formats.h"

namespace grtx::frontend {
namespace {

struct ErrorText {
  char text[128] = "";
};

void keep_error(png_structp png, png_const_charp message) {
  auto* error = static_cast<ErrorText*>(png_get_error_ptr(png));
  std::strncpy(error->text, message, sizeof error->text - 1);
  png_longjmp(png, 1);
}

void ignore_warning(png_structp, png_const_charp) {}

void append(png_structp png, png_bytep bytes, std::size_t count) {
  static_cast<std::string*>(png_get_io_ptr(png))->append(reinterpret_cast<const char*>(bytes), count);
}

void no_flush(png_structp) {}

class Writer {
 public:
  Writer() : png_(png_create_write_struct(PNG_LIBPNG_VER_STRING, &error_, keep_error, ignore_warning)) {
    if (png_ != nullptr) info_ = png_create_info_struct(png_);
    if (info_ == nullptr) throw std::bad_alloc();
  }
  ~Writer() { png_destroy_write_struct(&png_, &info_); }
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;

  bool write(unsigned width, unsigned height, const png_byte* rgb) {
    if (setjmp(png_jmpbuf(png_)) != 0) return false;
    png_set_write_fn(png_, &file_, append, no_flush);
    png_set_IHDR(png_, info_, width, height, 8, PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
                 PNG_FILTER_TYPE_DEFAULT);
    png_write_info(png_, info_);
    for (unsigned y = 0; y < height; ++y) png_write_row(png_, rgb + std::size_t{3} * width * y);
    png_write_end(png_, info_);
    return true;
  }

  const char* error() const { return error_.text; }
  std::string& file() { return file_; }

 private:
  ErrorText error_;
  std::string file_;
  png_structp png_ = nullptr;
  png_infop info_ = nullptr;
};

struct Source {
  const char* bytes;
  std::size_t size;
  std::size_t at;
};

void take(png_structp png, png_bytep out, std::size_t count) {
  auto* source = static_cast<Source*>(png_get_io_ptr(png));
  if (source->size - source->at < count) png_error(png, "the file ends early");
  std::memcpy(out, source->bytes + source->at, count);
  source->at += count;
}

class Reader {
 public:
  explicit Reader(const std::string& bytes)
      : source_{bytes.data(), bytes.size(), 0},
        png_(png_create_read_struct(PNG_LIBPNG_VER_STRING, &error_, keep_error, ignore_warning)) {
    if (png_ != nullptr) info_ = png_create_info_struct(png_);
    if (info_ == nullptr) throw std::bad_alloc();
  }
  ~Reader() { png_destroy_read_struct(&png_, &info_, nullptr); }
  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;

  /// Converts every kind of PNG to 8-bit RGB; colour-space chunks are ignored on purpose: values are taken as they are.
  bool read_header() {
    if (setjmp(png_jmpbuf(png_)) != 0) return false;
    png_set_read_fn(png_, &source_, take);
    png_read_info(png_, info_);
    png_set_expand(png_);
    png_set_scale_16(png_);
    png_set_strip_alpha(png_);
    png_set_gray_to_rgb(png_);
    png_set_interlace_handling(png_);
    png_read_update_info(png_, info_);
    return true;
  }

  bool read_rows(png_bytepp rows) {
    if (setjmp(png_jmpbuf(png_)) != 0) return false;
    png_read_image(png_, rows);
    png_read_end(png_, nullptr);
    return true;
  }

  unsigned width() const { return png_get_image_width(png_, info_); }
  unsigned height() const { return png_get_image_height(png_, info_); }
  std::size_t row_bytes() const { return png_get_rowbytes(png_, info_); }
  std::size_t at() const { return source_.at; }
  const char* error() const { return error_.text; }

 private:
  ErrorText error_;
  Source source_;
  png_structp png_ = nullptr;
  png_infop info_ = nullptr;
};

}  // namespace

std::string encode_png(const std::string& path, const Image& image) {
  std::vector<png_byte> rgb;
  rgb.reserve(image.pixels.size() * 3);
  for (const glm::vec3& pixel : image.pixels) {
    for (int c = 0; c < 3; ++c) rgb.push_back(colour_byte(pixel[c]));
  }
  Writer writer;
  if (!writer.write(image.width, image.height, rgb.data())) throw Error(path, "", writer.error());
  return std::move(writer.file());
}

Image decode_png(const std::string& path, const std::string& bytes) {
  Reader reader(bytes);
  const auto failed = [&] {
    return Error(path, fmt::format("byte {}", reader.at()),
                 fmt::format("must be a complete PNG file: {}", reader.error()));
  };
  if (!reader.read_header()) throw failed();
  const std::uint64_t count = std::uint64_t{reader.width()} * reader.height();
  if (count == 0 || count > kMaxImagePixels) {
    throw Error(path, "header", fmt::format("has more than {} pixels", kMaxImagePixels));
  }
  if (reader.row_bytes() != std::size_t{3} * reader.width()) throw Error(path, "header", "cannot be read as 8-bit RGB");
  std::vector<png_byte> rgb(count * 3);
  std::vector<png_bytep> rows(reader.height());
  for (std::size_t y = 0; y < rows.size(); ++y) rows[y] = rgb.data() + y * reader.row_bytes();
  if (!reader.read_rows(rows.data())) throw failed();
  Image image(reader.width(), reader.height());
  for (std::size_t i = 0; i < image.pixels.size(); ++i) {
    for (std::size_t c = 0; c < 3; ++c)
      image.pixels[i][static_cast<int>(c)] = static_cast<float>(rgb[3 * i + c]) / 255.0f;
  }
  return image;
}

}  // namespace grtx::frontend
