#include "tests/eval/figure/matrix.h"

#include <vtkContext2D.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/eval/figure/canvas.h"
#include "tests/eval/figure/draw_item.h"

namespace haptics::eval {
namespace {

constexpr double kMargin = 36, kHeader = 78, kLine = 25, kKey = 44;
constexpr double kCellWidth = 246, kCellHeight = 162, kGap = 8;
constexpr int kTitleFont = 32, kHeadFont = 21, kTextFont = 17, kSmallFont = 14;
constexpr Colour kInk{0.13, 0.15, 0.18}, kSoft{0.42, 0.46, 0.51}, kRule{0.86, 0.875, 0.89}, kPaper{0.972, 0.975, 0.98};
constexpr Colour kDiagonal{0.16, 0.30, 0.48}, kWhite{1, 1, 1}, kPale{0.80, 0.86, 0.93};
constexpr Colour kGood{0.10, 0.55, 0.33}, kBad{0.78, 0.16, 0.16};
constexpr Colour kMeasured{0.0, 0.447, 0.698}, kExpected{0.95, 0.78, 0.25};

struct Corner {
  double left, below;
};

class MatrixPainter final : public vtkContextItem {
 public:
  static MatrixPainter* New();
  vtkTypeMacro(MatrixPainter, vtkContextItem) void set(const Matrix& matrix) { matrix_ = &matrix; }

  [[nodiscard]] static int width_px(const Matrix& matrix) {
    return static_cast<int>(2 * kMargin + static_cast<double>(matrix.entries.size()) * (kCellWidth + kGap) - kGap);
  }
  [[nodiscard]] static int height_px(const Matrix& matrix) {
    return static_cast<int>(kHeader + kLine * static_cast<double>(matrix.caption.size()) + kKey +
                            static_cast<double>(matrix.entries.size()) * (kCellHeight + kGap) + kMargin);
  }

  bool Paint(vtkContext2D* context) override {
    Canvas canvas(*context);
    double top = height_px(*matrix_) - kHeader;
    canvas.text(kMargin, top + 24, matrix_->title, kTitleFont, kInk, Align::kLeft, true);
    for (const std::string& words : matrix_->caption) {
      top -= kLine;
      canvas.text(kMargin, top + 14, words, kTextFont, kSoft);
    }
    top -= kKey;
    paintKey(canvas, top + 14);
    top_ = top;
    for (std::size_t i = 0; i < matrix_->entries.size(); ++i) {
      const Corner at = corner(i, i);
      canvas.box({at.left, at.below}, kCellWidth, kCellHeight, kDiagonal);
      const double middle = at.left + kCellWidth / 2;
      canvas.text(middle, at.below + kCellHeight / 2 + 2, matrix_->entries[i].title, kHeadFont, kWhite, Align::kCentre,
                  true);
      canvas.text(middle, at.below + kCellHeight / 2 - 24, matrix_->entries[i].note, kSmallFont, kPale, Align::kCentre);
    }
    for (const MatrixCell& cell : matrix_->cells) {
      paintPlot(canvas, cell, corner(cell.row, cell.column));
      paintBars(canvas, cell, corner(cell.column, cell.row));
    }
    return true;
  }

 private:
  [[nodiscard]] Corner corner(std::size_t row, std::size_t column) const {
    return {kMargin + static_cast<double>(column) * (kCellWidth + kGap),
            top_ - static_cast<double>(row + 1) * (kCellHeight + kGap) + kGap};
  }

  static void paintKey(Canvas& canvas, double base) {
    double left = kMargin;
    const auto entry = [&](Colour colour, double height, const char* meaning) {
      canvas.box({left, base + 8 - height / 2}, 26, height, colour);
      canvas.text(left + 34, base, meaning, kTextFont, kInk);
      left += 60 + canvas.textWidth(meaning, kTextFont, false);
    };
    entry(kExpected, 6, "reference");
    entry(kMeasured, 2.5, "felt");
    entry(kGood, 10, "within its limit");
    entry(kBad, 10, "beyond it");
  }

  [[nodiscard]] static bool good(const MatrixCell& cell) {
    return std::ranges::all_of(cell.bars, [](const MatrixBar& bar) { return bar.share <= 1; });
  }

  static void paintTitle(Canvas& canvas, const std::string& title, Corner at) {
    canvas.text(at.left + 12, at.below + kCellHeight - 24, title, kSmallFont, kInk, Align::kLeft, true);
  }

  static void paintPlot(Canvas& canvas, const MatrixCell& cell, Corner at) {
    canvas.box({at.left, at.below}, kCellWidth, kCellHeight, kPaper);
    paintTitle(canvas, cell.title, at);
    const double named = canvas.textWidth(cell.title, kSmallFont, true);
    canvas.text(at.left + 12 + named + 8, at.below + kCellHeight - 24, cell.plotTitle, kSmallFont, kSoft);
    canvas.disc({at.left + kCellWidth - 16, at.below + kCellHeight - 16}, 6, good(cell) ? kGood : kBad);
    if (cell.expected.empty()) return;
    constexpr double kLeft = 46, kBelow = 26, kRight = 14, kAbove = 34;
    const double width = kCellWidth - kLeft - kRight, height = kCellHeight - kBelow - kAbove;
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const auto* curve : {&cell.measured, &cell.expected}) {
      for (const auto& [x, y] : *curve) {
        low = std::min(low, y);
        high = std::max(high, y);
      }
    }
    // A curve that hardly changes is shown as level, not as its rounding.
    constexpr double kMinShare = 0.1;
    const double missing = std::max(0.0, kMinShare * std::max(std::abs(low), std::abs(high)) - (high - low));
    const double room = missing / 2 + 0.08 * (high - low + missing) + 1e-12;
    low -= room;
    high += room;
    const double longest = cell.expected.back().first;
    const auto place = [&](double x, double y) {
      return Canvas::Point{at.left + kLeft + width * x / longest,
                           at.below + kBelow + height * std::clamp((y - low) / (high - low), 0.0, 1.0)};
    };
    const double step = stepFor(high - low);
    for (double tick = std::ceil(low / step); tick * step <= high; ++tick) {
      const double up = place(0, tick * step).y;
      canvas.line({at.left + kLeft, up}, {at.left + kLeft + width, up}, kRule, 1);
      canvas.text(at.left + kLeft - 6, up - 8, numberText(tick * step), kSmallFont, kSoft, Align::kRight);
    }
    for (const auto& [curve, colour, wide] :
         {std::tuple{&cell.expected, kExpected, 5.0}, std::tuple{&cell.measured, kMeasured, 1.6}}) {
      std::vector<Canvas::Point> points;
      for (const auto& [x, y] : *curve) points.push_back(place(x, y));
      canvas.polyline(points, colour, wide);
    }
    canvas.text(at.left + kLeft, at.below + 5, "0", kSmallFont, kSoft);
    canvas.text(at.left + kLeft + width, at.below + 5, numberText(longest) + " s", kSmallFont, kSoft, Align::kRight);
  }

  static void paintBars(Canvas& canvas, const MatrixCell& cell, Corner at) {
    constexpr double kName = 134, kBar = 52, kRow = 17.5;
    canvas.box({at.left, at.below}, kCellWidth, kCellHeight, kPaper);
    paintTitle(canvas, cell.title, at);
    double base = at.below + kCellHeight - 44;
    const double from = at.left + 12 + kName;
    for (const MatrixBar& bar : cell.bars) {
      const bool within = bar.share <= 1;
      canvas.text(at.left + 12, base, bar.name, kSmallFont, within ? kInk : kBad);
      canvas.box({from, base + 4}, kBar, 8, kRule);
      canvas.box({from, base + 4}, kBar * (within ? std::max(bar.share, 0.015) : 1.0), 8, within ? kGood : kBad);
      canvas.line({from + kBar, base + 1}, {from + kBar, base + 15}, kInk, 1.4);
      canvas.text(at.left + kCellWidth - 8, base, bar.value, kSmallFont, within ? kInk : kBad, Align::kRight);
      base -= kRow;
    }
  }

  [[nodiscard]] static std::string numberText(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.3g", std::abs(value) < 1e-12 ? 0 : value);
    return text;
  }
  /// 1, 2 or 5 times a power of ten, about a third of the range.
  [[nodiscard]] static double stepFor(double range) {
    const double raw = range / 3, decade = std::pow(10, std::floor(std::log10(raw))), part = raw / decade;
    return decade * (part < 1.5 ? 1 : part < 3.5 ? 2 : part < 7.5 ? 5 : 10);
  }

  const Matrix* matrix_ = nullptr;
  double top_ = 0;
};

vtkStandardNewMacro(MatrixPainter)

}  // namespace

Result<void> drawMatrix(const Matrix& matrix, const std::filesystem::path& png) {
  vtkNew<MatrixPainter> painter;
  painter->set(matrix);
  return drawItem(*painter, MatrixPainter::width_px(matrix), MatrixPainter::height_px(matrix), matrix.title, png, {});
}

}  // namespace haptics::eval
