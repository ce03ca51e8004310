#include "render/stroke_font.hpp"

#include <cmath>
#include <numbers>
#include <string>
#include <unordered_map>

namespace turgor::render_detail {
namespace {

struct Drawing {
  char32_t letter;
  float width;
  /// M x y: lift the pen to; L x y: line to; A cx cy rx ry a b: line to, then arc from a to b degrees; a: the
  /// same with the pen lifted first.
  const char* path;
};

constexpr Drawing drawings[] = {
    {U' ', 1.6f, ""},
    {U'A', 8, "M0 0L4 10L8 0M1.4 3.4L6.6 3.4"},
    {U'B', 7, "M0 0L0 10L3.8 10A3.8 7.6 2.6 2.4 90 -90L0 5.2M3.8 5.2A4 2.6 3 2.6 90 -90L0 0"},
    {U'C', 7.8f, "a4.6 5 4.6 5 48 312"},
    {U'D', 7.8f, "M0 0L0 10L3 10A3 5 4.8 5 90 -90L0 0"},
    {U'E', 6, "M6 10L0 10L0 0L6 0M0 5.2L5 5.2"},
    {U'F', 6, "M6 10L0 10L0 0M0 5.2L5 5.2"},
    {U'G', 8.2f, "a4.6 5 4.6 5 45 318L8 4.6L5 4.6"},
    {U'H', 7.4f, "M0 0L0 10M7.4 0L7.4 10M0 5.2L7.4 5.2"},
    {U'I', 0, "M0 0L0 10"},
    {U'J', 4.6f, "M4.6 10L4.6 2.6A2.3 2.6 2.3 2.6 0 -170"},
    {U'K', 7, "M0 0L0 10M6.8 10L0 3.6M2.6 6L7 0"},
    {U'L', 5.6f, "M0 10L0 0L5.6 0"},
    {U'M', 8.8f, "M0 0L0 10L4.4 3L8.8 10L8.8 0"},
    {U'N', 7.2f, "M0 0L0 10L7.2 0L7.2 10"},
    {U'O', 9.4f, "a4.7 5 4.7 5 0 360"},
    {U'P', 6.8f, "M0 0L0 10L3.8 10A3.8 7.2 3 2.8 90 -90L0 4.4"},
    {U'Q', 9.4f, "a4.7 5 4.7 5 0 360M5.8 2.8L9 -1"},
    {U'R', 7, "M0 0L0 10L3.8 10A3.8 7.2 3 2.8 90 -90L0 4.4M3.6 4.4L7 0"},
    {U'S', 6.7f, "a3.4 7.5 3 2.5 35 270A3.4 2.5 3.3 2.5 90 -145"},
    {U'T', 7.4f, "M0 10L7.4 10M3.7 10L3.7 0"},
    {U'U', 7.2f, "M0 10L0 3.5A3.6 3.5 3.6 3.5 180 360L7.2 10"},
    {U'V', 7.8f, "M0 10L3.9 0L7.8 10"},
    {U'W', 11.2f, "M0 10L2.8 0L5.6 9L8.4 0L11.2 10"},
    {U'X', 7, "M0 0L7 10M0 10L7 0"},
    {U'Y', 7.4f, "M0 10L3.7 5L7.4 10M3.7 5L3.7 0"},
    {U'Z', 6.8f, "M0 10L6.8 10L0 0L6.8 0"},
    {U'a', 5, "a2.6 4.6 2.4 2.4 155 0L5 0M5 4.1L2.3 4.1A2.3 2.05 2.3 2.05 90 270A2.3 2.6 2.7 2.6 270 345"},
    {U'b', 5.8f, "M0 10L0 0a2.9 3.5 2.9 3.5 0 360"},
    {U'c', 4.9f, "a2.9 3.5 2.9 3.5 50 310"},
    {U'd', 5.8f, "M5.8 10L5.8 0a2.9 3.5 2.9 3.5 0 360"},
    {U'e', 5.7f, "M0.1 3.6L5.7 3.6A2.9 3.5 2.85 3.5 0 318"},
    {U'f', 3.8f, "a3.2 7.8 1.9 2.2 65 180L1.3 0M0 6.8L3.6 6.8"},
    {U'g', 5.8f, "a2.9 3.5 2.9 3.5 0 360M5.8 6.9L5.8 -0.4A2.9 -0.4 2.9 2.6 0 -150"},
    {U'h', 5.2f, "M0 10L0 0M0 4.2A2.6 4.2 2.6 2.8 180 0L5.2 0"},
    {U'i', 0, "M0 7L0 0M0 9.5L0 9.8"},
    {U'j', 1.6f, "M1.6 7L1.6 -1A0 -1 1.6 2 0 -95M1.6 9.5L1.6 9.8"},
    {U'k', 5.2f, "M0 10L0 0M5 7L0 2.6M1.9 4.3L5.2 0"},
    {U'l', 1.8f, "M0 10L0 1.6A1.6 1.6 1.6 1.6 180 280"},
    {U'm', 8, "M0 7L0 0M0 4.6A2 4.6 2 2.4 180 0L4 0M4 4.6A6 4.6 2 2.4 180 0L8 0"},
    {U'n', 5.2f, "M0 7L0 0M0 4.2A2.6 4.2 2.6 2.8 180 0L5.2 0"},
    {U'o', 5.9f, "a2.95 3.5 2.95 3.5 0 360"},
    {U'p', 5.8f, "M0 7L0 -3a2.9 3.5 2.9 3.5 0 360"},
    {U'q', 5.8f, "M5.8 7L5.8 -3a2.9 3.5 2.9 3.5 0 360"},
    {U'r', 3.2f, "M0 7L0 0M0 4A2.6 4 2.6 3 180 75"},
    {U's', 4.8f, "a2.4 5.25 2.2 1.75 30 270A2.4 1.75 2.4 1.75 90 -145"},
    {U't', 3.8f, "M1.4 9.4L1.4 1.8A3.1 1.8 1.7 1.8 180 290M0 6.8L3.7 6.8"},
    {U'u', 5.2f, "M0 7L0 2.8A2.6 2.8 2.6 2.8 180 360M5.2 7L5.2 0"},
    {U'v', 5.6f, "M0 7L2.8 0L5.6 7"},
    {U'w', 8, "M0 7L2 0L4 6.2L6 0L8 7"},
    {U'x', 5, "M0 0L5 7M0 7L5 0"},
    {U'y', 5.6f, "M0 7L2.8 0.2M5.6 7L2.3 -1.7A1 -1.4 1.4 1.6 -15 -100"},
    {U'z', 4.8f, "M0 7L4.8 7L0 0L4.8 0"},
    {U'0', 6, "a3 5 3 5 0 360"},
    {U'1', 6, "M0.8 7.9L3.4 10L3.4 0"},
    {U'2', 6, "a3 7.1 2.8 2.9 165 -35L0.2 0L6 0"},
    {U'3', 6, "a2.9 7.6 2.6 2.4 150 -90A2.9 2.6 3 2.6 90 -150"},
    {U'4', 6, "M4.6 0L4.6 10L0 3L6 3"},
    {U'5', 6, "M5.4 10L1 10L0.5 5A2.8 3.2 3.1 3.2 135 -150"},
    {U'6', 6, "a3 3.2 3 3.2 0 360a5 3.2 5 6.8 180 92"},
    {U'7', 6, "M0 10L6 10L2 0"},
    {U'8', 6, "a3 7.6 2.5 2.4 0 360a3 2.6 3 2.6 0 360"},
    {U'9', 6, "a3 6.8 3 3.2 0 360a1 6.8 5 6.8 0 -88"},
    {U'.', 0, "M0 0.1L0 0.3"},
    {U',', 0.6f, "M0.6 0.4L0 -1.8"},
    {U':', 0, "M0 0.1L0 0.3M0 5.6L0 5.8"},
    {U';', 0.6f, "M0.6 0.4L0 -1.8M0.6 5.6L0.6 5.8"},
    {U'!', 0, "M0 10L0 3M0 0.1L0 0.3"},
    {U'?', 5, "a2.5 7.6 2.5 2.4 165 -60L2.4 4.4L2.4 3M2.4 0.1L2.4 0.3"},
    {U'\'', 0, "M0 10L0 7"},
    {U'"', 2, "M0 10L0 7M2 10L2 7"},
    {U'`', 1.4f, "M0 10L1.4 8.2"},
    {U'-', 3.4f, "M0 3.8L3.4 3.8"},
    {U'–', 6, "M0 3.8L6 3.8"},
    {U'—', 9, "M0 3.8L9 3.8"},
    {U'−', 6, "M0 4.4L6 4.4"},
    {U'+', 6, "M0 4.4L6 4.4M3 1.4L3 7.4"},
    {U'±', 6, "M0 5.6L6 5.6M3 2.6L3 8.6M0 0.2L6 0.2"},
    {U'=', 6, "M0 3L6 3M0 5.8L6 5.8"},
    {U'×', 6, "M0.5 1.9L5.5 6.9M0.5 6.9L5.5 1.9"},
    {U'·', 0, "M0 3.9L0 4.1"},
    {U'/', 4.4f, "M0 -1.4L4.4 10.2"},
    {U'\\', 4.4f, "M0 10.2L4.4 -1.4"},
    {U'|', 0, "M0 -2.4L0 10.2"},
    {U'(', 1.8f, "a4 3.9 4 7 123 237"},
    {U')', 1.8f, "a-2.2 3.9 4 7 57 -57"},
    {U'[', 2, "M2 10.2L0 10.2L0 -2.4L2 -2.4"},
    {U']', 2, "M0 10.2L2 10.2L2 -2.4L0 -2.4"},
    {U'{', 2.6f, "M2.6 10.2L1.3 9.4L1.3 5L0 3.9L1.3 2.8L1.3 -1.6L2.6 -2.4"},
    {U'}', 2.6f, "M0 10.2L1.3 9.4L1.3 5L2.6 3.9L1.3 2.8L1.3 -1.6L0 -2.4"},
    {U'<', 5.6f, "M5.6 7.6L0 4.4L5.6 1.2"},
    {U'>', 5.6f, "M0 7.6L5.6 4.4L0 1.2"},
    {U'_', 6, "M0 -1.6L6 -1.6"},
    {U'#', 8, "M1.4 0L3 10M5 0L6.6 10M0 3.3L7.4 3.3M0.6 6.7L8 6.7"},
    {U'$', 6.7f, "a3.4 7.5 3 2.5 35 270A3.4 2.5 3.3 2.5 90 -145M3.4 10.2L3.4 -1.4"},
    {U'%', 8.4f, "a1.6 8.2 1.6 1.8 0 360a6.8 1.8 1.6 1.8 0 360M7 10L1.4 0"},
    {U'&', 7.4f, "M7.2 0L1.6 6.9A3.1 8.2 1.8 1.8 210 -30L1.2 4.6A2.7 2.5 2.7 2.5 130 320L7.2 4.6"},
    {U'*', 4.8f, "M2.4 10L2.4 5.2M0.3 8.8L4.5 6.4M0.3 6.4L4.5 8.8"},
    {U'@', 10, "a5 4.4 2 2.2 0 360M7 6.6L7 3.5A8.4 3.7 1.4 1.5 180 340A5 4.4 4.9 5.6 0 300"},
    {U'^', 4.8f, "M0 7L2.4 10L4.8 7"},
    {U'~', 5.6f, "M0 3.4L1.5 4.8L4.1 3.4L5.6 4.8"},
    {U'°', 3.2f, "a1.6 8.4 1.6 1.6 0 360"},
    {U'′', 0.8f, "M0.8 10L0 7.2"},
    {U'″', 2.8f, "M0.8 10L0 7.2M2.8 10L2 7.2"},
    {U'’', 0.8f, "M0.8 10L0 7.6"},
    {U'µ', 5.2f, "M0 7L0 -3M0 2.8A2.6 2.8 2.6 2.8 180 360M5.2 7L5.2 0"},
    {U'²', 3, "a1.5 9 1.4 1.2 160 -30L0.1 5.8L3 5.8"},
    {U'³', 3, "a1.5 9.2 1.3 0.9 150 -90A1.5 6.9 1.5 1.3 90 -150"},
    {U'Δ', 8, "M0 0L4 10L8 0L0 0"},
    {U'σ', 6.4f, "a2.95 3.4 2.95 3.4 0 360M2.95 6.8L6.4 6.8"},
    {U'→', 8, "M0 4.4L8 4.4M5.4 7L8 4.4L5.4 1.8"},
    {U'≤', 5.6f, "M5.6 9L0 6L5.6 3M0 0.4L5.6 0.4"},
    {U'≥', 5.6f, "M0 9L5.6 6L0 3M0 0.4L5.6 0.4"},
};

/// Reads the drawings' little language into strokes.
class Pen {
 public:
  explicit Pen(Glyph& glyph) : glyph_(glyph) {}

  void follow(const char* path) {
    while (*path) {
      const char command = *path++;
      float v[6]{};
      const int count = command == 'A' || command == 'a' ? 6 : 2;
      for (int i = 0; i < count; ++i) {
        char* end = nullptr;
        v[i] = std::strtof(path, &end);
        path = end;
      }
      if (command == 'M')
        x_ = v[0], y_ = v[1];
      else if (command == 'L')
        line_to(v[0], v[1]);
      else
        arc(v, command == 'a');
    }
  }

 private:
  void line_to(float x, float y) {
    glyph_.strokes.push_back({x_, y_, x, y});
    x_ = x, y_ = y;
  }

  void arc(const float* v, bool lifted) {
    const int steps = std::max(6, static_cast<int>(std::abs(v[5] - v[4]) / 12));
    for (int i = 0; i <= steps; ++i) {
      const float angle = (v[4] + (v[5] - v[4]) * static_cast<float>(i) / static_cast<float>(steps)) *
                          std::numbers::pi_v<float> / 180;
      const float x = v[0] + v[2] * std::cos(angle), y = v[1] + v[3] * std::sin(angle);
      if (i == 0 && lifted)
        x_ = x, y_ = y;
      else
        line_to(x, y);
    }
  }

  Glyph& glyph_;
  float x_ = 0, y_ = 0;
};

std::unordered_map<char32_t, Glyph> read_drawings() {
  std::unordered_map<char32_t, Glyph> font;
  for (const Drawing& d : drawings) {
    Glyph& g = font[d.letter];
    g.width = d.width;
    Pen(g).follow(d.path);
  }
  font[U'μ'] = font[U'µ'];  // Greek mu looks like the micro sign
  return font;
}

}  // namespace

const Glyph& glyph(char32_t letter) {
  static const std::unordered_map<char32_t, Glyph> font = read_drawings();
  static const Glyph box{6, {{0, 0, 6, 0}, {6, 0, 6, 10}, {6, 10, 0, 10}, {0, 10, 0, 0}}};
  const auto found = font.find(letter);
  return found == font.end() ? box : found->second;
}

std::u32string decode_utf8(std::string_view text) {
  std::u32string out;
  for (std::size_t i = 0; i < text.size();) {
    const auto lead = static_cast<unsigned char>(text[i++]);
    int more = lead < 0x80 ? 0 : lead >> 5 == 6 ? 1 : lead >> 4 == 14 ? 2 : lead >> 3 == 30 ? 3 : -1;
    if (more < 0) {
      out.push_back(U'\uFFFD');
      continue;
    }
    char32_t letter = more == 0 ? lead : static_cast<char32_t>(lead & (0x3F >> more));
    for (; more > 0 && i < text.size() && (static_cast<unsigned char>(text[i]) & 0xC0) == 0x80; --more)
      letter = letter << 6 | (static_cast<unsigned char>(text[i++]) & 0x3F);
    out.push_back(more > 0 ? U'\uFFFD' : letter);
  }
  return out;
}

}  // namespace turgor::render_detail
