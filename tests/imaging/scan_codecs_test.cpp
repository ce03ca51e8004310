// Decoders of compressed pixels against encoders written here, and against GDCM.
#include "imaging/scan/dicom_codecs.hpp"
#include "imaging/scan_dicom_files.hpp"
#include "turgor/core/random.hpp"

namespace turgor {
namespace {
using namespace scan_test;
using scan_io::PixelLayout;
using scan_io::Samples;

PixelLayout layout_of(int columns, int rows, int bits) {
  PixelLayout layout;
  layout.columns = columns, layout.rows = rows;
  layout.bits_allocated = bits > 8 ? 16 : 8;
  layout.bits_stored = bits, layout.high_bit = bits - 1;
  return layout;
}

/// A smooth ramp with some noise and one jump over the whole range.
Samples textured(int columns, int rows, int bits) {
  Samples samples;
  const RandomStream random(bits);
  const int highest = (1 << bits) - 1;
  for (int n = 0; n < columns * rows; ++n) {
    const int ramp = (n % columns + 2 * (n / columns)) * highest / (columns + 2 * rows);
    const int noise = static_cast<int>(random.bits(static_cast<std::uint64_t>(n)) % 9);
    samples.push_back(static_cast<std::uint16_t>(n == 5   ? 0
                                                 : n == 6 ? highest
                                                          : std::min(highest, ramp + noise)));
  }
  return samples;
}

/// Lossless JPEG written from annex H: 17 categories of difference, each with a code of five bits.
class LosslessEncoder {
 public:
  LosslessEncoder(const Samples& samples, int columns, int rows, int bits, int predictor, int transform,
                  int interval)
      : samples_(samples), columns_(columns), bits_(bits), predictor_(predictor), transform_(transform) {
    put({0xFF, 0xD8, 0xFF, 0xC3, 0, 11, bits, rows >> 8, rows & 255, columns >> 8, columns & 255, 1, 1, 0x11,
         0});
    put({0xFF, 0xC4, 0, 36, 0, 0, 0, 0, 0, 17, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0});
    for (int category = 0; category <= 16; ++category) put({category});
    if (interval > 0) put({0xFF, 0xDD, 0, 4, interval >> 8, interval & 255});
    put({0xFF, 0xDA, 0, 8, 1, 1, 0, predictor, 0, transform});
    int restarts = 0;
    for (int n = 0; n < columns * rows; ++n) {
      if (interval > 0 && n > 0 && n % interval == 0) {
        flush();
        put({0xFF, 0xD0 + restarts++ % 8});
        first_row_ = n / columns;
      }
      encode(n);
    }
    flush();
    put({0xFF, 0xD9});
  }
  [[nodiscard]] scan_io::Bytes bytes() const { return std::as_bytes(std::span(out_.data(), out_.size())); }

 private:
  [[nodiscard]] int at(int n) const { return samples_[static_cast<std::size_t>(n)] >> transform_; }
  [[nodiscard]] int prediction(int n) const {
    const int x = n % columns_, y = n / columns_;
    if (y == first_row_) return x > 0 ? at(n - 1) : 1 << (bits_ - transform_ - 1);
    if (x == 0) return at(n - columns_);
    const int a = at(n - 1), b = at(n - columns_), c = at(n - columns_ - 1);
    const std::array<int, 8> all{0, a, b, c, a + b - c, a + ((b - c) >> 1), b + ((a - c) >> 1), (a + b) / 2};
    return all[static_cast<std::size_t>(predictor_)];
  }
  void encode(int n) {
    // Modulo 65536, between -32767 and 32768 (H.1.2.1).
    int difference = static_cast<std::int16_t>(at(n) - prediction(n));
    if (difference == -32768) difference = 32768;
    int category = 0;
    while (std::abs(difference) >> category != 0) ++category;
    bits(category, 5);
    if (category > 0 && category < 16) bits(difference < 0 ? difference - 1 : difference, category);
  }
  void bits(int value, int count) {
    for (int b = count - 1; b >= 0; --b) {
      buffer_ = buffer_ << 1 | (value >> b & 1);
      if (++held_ == 8) byte();
    }
  }
  void flush() {
    while (held_ > 0) bits(1, 1);
  }
  void byte() {
    put({buffer_});
    if (buffer_ == 0xFF) put({0});
    buffer_ = held_ = 0;
  }
  void put(std::initializer_list<int> values) {
    for (const int v : values) out_ += static_cast<char>(v);
  }

  const Samples& samples_;
  int columns_, bits_, predictor_, transform_, first_row_ = 0, buffer_ = 0, held_ = 0;
  std::string out_;
};

TEST(Codecs, LosslessJpegReadsEveryPredictor) {
  for (const int bits : {8, 12, 16}) {
    const Samples samples = textured(23, 17, bits);
    for (int predictor = 1; predictor <= 7; ++predictor) {
      const LosslessEncoder coded(samples, 23, 17, bits, predictor, 0, 0);
      const auto decoded = decode_jpeg(coded.bytes(), layout_of(23, 17, bits));
      ASSERT_TRUE(decoded) << bits << " bits, predictor " << predictor;
      EXPECT_EQ(*decoded, samples) << bits << " bits, predictor " << predictor;
    }
  }
}

TEST(Codecs, LosslessJpegReadsRestartsAndPointTransform) {
  Samples samples = textured(23, 17, 12);
  const LosslessEncoder restarted(samples, 23, 17, 12, 4, 0, 23 * 3);
  const auto decoded = decode_jpeg(restarted.bytes(), layout_of(23, 17, 12));
  ASSERT_TRUE(decoded);
  EXPECT_EQ(*decoded, samples);
  const LosslessEncoder shifted(samples, 23, 17, 12, 7, 3, 0);
  const auto coarse = decode_jpeg(shifted.bytes(), layout_of(23, 17, 12));
  ASSERT_TRUE(coarse);
  for (auto& v : samples) v = static_cast<std::uint16_t>(v & ~7);
  EXPECT_EQ(*coarse, samples);
}

TEST(Codecs, RefuseStreamsOfAnotherSize) {
  const Samples samples = textured(23, 17, 12);
  const LosslessEncoder coded(samples, 23, 17, 12, 1, 0, 0);
  EXPECT_FALSE(decode_jpeg(coded.bytes(), layout_of(17, 23, 12)));
  EXPECT_FALSE(decode_jpeg(coded.bytes(), layout_of(23, 18, 12)));
  EXPECT_FALSE(decode_jpeg(coded.bytes(), layout_of(23, 17, 8)));
  EXPECT_FALSE(decode_jpeg_ls(coded.bytes(), layout_of(23, 17, 12)));
  EXPECT_FALSE(decode_jpeg_2000(coded.bytes(), layout_of(23, 17, 12)));
  EXPECT_FALSE(decode_rle(coded.bytes(), layout_of(23, 17, 12)));
}

/// What GDCM reads from a file.
std::vector<std::int16_t> gdcm_pixels(const std::filesystem::path& path, int allocated) {
  gdcm::ImageReader reader;
  reader.SetFileName(path.c_str());
  EXPECT_TRUE(reader.Read());
  std::string buffer(reader.GetImage().GetBufferLength(), '\0');
  EXPECT_TRUE(reader.GetImage().GetBuffer(buffer.data()));
  std::vector<std::int16_t> values(buffer.size() * 8 / static_cast<std::size_t>(allocated));
  for (std::size_t n = 0; n < values.size(); ++n) {
    if (allocated == 8) values[n] = static_cast<unsigned char>(buffer[n]);
    if (allocated == 16) std::memcpy(&values[n], buffer.data() + 2 * n, 2);
  }
  return values;
}

TEST(Codecs, LossyJpegAgreesWithGdcm) {
  using TS = gdcm::TransferSyntax;
  for (const int bits : {8, 12}) {
    const auto syntax = bits == 8 ? TS::JPEGBaselineProcess1 : TS::JPEGExtendedProcess2_4;
    const Scratch scratch(std::to_string(bits));
    const Lattice lattice{{30, 22, 2}, {}, {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}}, {0, 0, 0}};
    write_series(scratch.path(), lattice, [&](int, DicomSpec& spec) {
      const Samples samples = textured(30, 22, bits);
      spec.syntax = syntax, spec.is_signed = false;
      spec.allocated = bits > 8 ? 16 : 8, spec.stored = bits;
      spec.pixels.clear();
      for (const std::uint16_t v : samples) {
        spec.pixels += static_cast<char>(v & 255);
        if (bits > 8) spec.pixels += static_cast<char>(v >> 8);
      }
    });
    const auto scan = read(scratch.path());
    ASSERT_TRUE(scan) << scan.error().message();
    const auto expected = gdcm_pixels(scratch / "0.dcm", bits > 8 ? 16 : 8);
    ASSERT_EQ(expected.size(), 30U * 22U);
    int largest = 0;
    for (std::size_t n = 0; n < expected.size(); ++n) {
      largest = std::max(largest, std::abs(expected[n] - scan->hu.voxels[n]));
    }
    EXPECT_LE(largest, 1) << bits;  // the standard leaves the last bit of the transform open
  }
}

TEST(Codecs, JpegLsAgreesWithGdcmAtEveryDepthAndLoss) {
  for (const int bits : {8, 12, 16}) {
    for (const int loss : {0, 1, 3}) {
      const Scratch scratch(fmt::format("{}.{}", bits, loss));
      SCOPED_TRACE(fmt::format("{} bits, loss {}", bits, loss));
      DicomSpec spec;
      spec.columns = 70, spec.rows = 46, spec.is_signed = false;
      spec.allocated = bits > 8 ? 16 : 8, spec.stored = bits;
      Samples samples = textured(70, 46, bits);
      std::fill(samples.begin() + 1000, samples.begin() + 1900, samples[999]);  // runs, across lines
      for (std::size_t n = 1200; n < 1800; n += 97) samples[n] ^= 3;            // and what breaks them
      for (std::uint16_t& v : samples) {
        v = static_cast<std::uint16_t>(
            std::min(int{v}, (1 << bits) - 1 - loss));  // GDCM may err beyond the top
        spec.pixels += static_cast<char>(v & 255);
        if (bits > 8) spec.pixels += static_cast<char>(v >> 8);
      }
      write_dicom(scratch / "a.dcm", spec);
      recode_jpeg_ls(scratch / "a.dcm", loss);
      const std::string file = read_text(scratch / "a.dcm");
      const auto bytes = std::as_bytes(std::span(file.data(), file.size()));
      const auto outcome = scan_io::parse_dicom_info(bytes, bytes.size(), "a.dcm");
      ASSERT_TRUE(outcome.info) << outcome.fault;
      std::vector<std::int16_t> ours(samples.size());
      ASSERT_TRUE(read_dicom_pixels(outcome.info->slices.front(), bytes, ours));
      const auto theirs = gdcm_pixels(scratch / "a.dcm", spec.allocated);
      for (std::size_t n = 0; n < samples.size(); ++n) {
        const int stored = static_cast<std::uint16_t>(theirs[n]);
        ASSERT_EQ(ours[n], std::min(stored, 32767)) << n;
        ASSERT_LE(std::abs(stored - samples[n]), loss) << n;
      }
    }
  }
}

}  // namespace
}  // namespace turgor
