#include "tests/eval/figure/contact_sheet.h"

#include <vtkContext2D.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/eval/figure/draw_item.h"

namespace haptics::eval {
namespace {

constexpr double kMargin = 36, kCardWidth = 916, kCardHeight = 226, kGap = 18, kHeader = 74, kLine = 25;
constexpr double kPicture = 152, kPlotLeft = 46;
constexpr double kWidth = 2 * kMargin + 2 * kCardWidth + kGap;
constexpr double kGridsHeight = 340, kSquare = 34, kPlotsHeight = 270;
constexpr int kTitleFont = 32, kHeadFont = 21, kTextFont = 17, kSmallFont = 14;
constexpr Colour kInk{0.13, 0.15, 0.18}, kSoft{0.42, 0.46, 0.51}, kRule{0.86, 0.875, 0.89}, kPaper{0.972, 0.975, 0.98};
constexpr Colour kGood{0.10, 0.55, 0.33}, kBad{0.78, 0.16, 0.16};

std::string numberText(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", std::abs(value) < 1e-12 ? 0 : value);
  return text;
}

/// 1, 2 or 5 times a power of ten, about a third of the range.
double stepFor(double range) {
  const double raw = range / 3;
  const double decade = std::pow(10, std::floor(std::log10(raw)));
  const double part = raw / decade;
  return decade * (part < 1.5 ? 1 : part < 3.5 ? 2 : part < 7.5 ? 5 : 10);
}

struct Extent {
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  void take(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
  [[nodiscard]] double share(double value) const { return (value - low) / (high - low); }
};

struct Frame {
  double left, below, width, height;
};

class SheetPainter final : public vtkContextItem {
 public:
  static SheetPainter* New();
  vtkTypeMacro(SheetPainter, vtkContextItem) void set(const ContactSheet& sheet) { sheet_ = &sheet; }

  [[nodiscard]] static double cardsHeight(const ContactSheet& sheet) {
    const std::size_t rows = (sheet.cards.size() + 1) / 2;
    return static_cast<double>(rows) * (kCardHeight + kGap);
  }
  [[nodiscard]] static int height_px(const ContactSheet& sheet) {
    return static_cast<int>(kHeader + kLine * static_cast<double>(sheet.caption.size()) + cardsHeight(sheet) +
                            kGridsHeight + kPlotsHeight + 2 * kGap);
  }

  bool Paint(vtkContext2D* context) override {
    Canvas canvas(*context);
    double top = height_px(*sheet_) - kHeader;
    canvas.text(kMargin, top + 18, sheet_->title, kTitleFont, kInk, Align::kLeft, true);
    for (const std::string& words : sheet_->caption) {
      top -= kLine;
      canvas.text(kMargin, top + 8, words, kTextFont, kSoft);
    }
    for (std::size_t i = 0; i < sheet_->cards.size(); ++i) {
      const double left = kMargin + static_cast<double>(i % 2) * (kCardWidth + kGap);
      const std::size_t row = i / 2 + 1;
      card(canvas, sheet_->cards[i], left, top - static_cast<double>(row) * (kCardHeight + kGap) + kGap / 2);
    }
    top -= cardsHeight(*sheet_);
    grids(canvas, sheet_->grids, top - kGridsHeight);
    plots(canvas, top - kGridsHeight - kPlotsHeight);
    return true;
  }

 private:
  static void card(Canvas& canvas, const SheetCard& card, double left, double below) {
    canvas.box({left, below}, kCardWidth, kCardHeight, kPaper);
    const double top = below + kCardHeight;
    canvas.disc({left + 20, top - 19}, 7, card.good ? kGood : kBad);
    canvas.text(left + 36, top - 30, card.title, kHeadFont, kInk, Align::kLeft, true);
    const double foot = below + 28;
    canvas.raster(card.picture, {left + 14, foot}, kPicture, kPicture);
    canvas.text(left + 14 + kPicture / 2, below + 8, card.scale, kSmallFont, kSoft, Align::kCentre);
    double from = left + 14 + kPicture;
    constexpr double kWide = 192;
    for (const SheetPlot& each : card.plots) {
      plot(canvas, each, {from + kPlotLeft, foot + 14, kWide, kPicture - 32});
      from += kPlotLeft + kWide + 4;
    }
    double line = top - 58;
    for (const std::string& words : card.verdict) {
      canvas.text(from + 16, line, words, kSmallFont, kInk);
      line -= 20;
    }
  }

  static void plot(Canvas& canvas, const SheetPlot& plot, Frame at) {
    Extent x;
    Extent y;
    for (const SheetCurve& curve : plot.curves) {
      for (const auto& [px, py] : curve.points) {
        x.take(px);
        y.take(py);
      }
    }
    if (plot.fromZero) y.take(0);
    const double room = 0.06 * std::max(y.high - y.low, 1e-12);
    y.high += room;
    if (!plot.fromZero) y.low -= room;
    const auto place = [&](double px, double py) {
      return Canvas::Point{at.left + at.width * x.share(px), at.below + at.height * std::clamp(y.share(py), 0.0, 1.0)};
    };
    axes(canvas, plot, at, x, y);
    double name = at.left + at.width;
    for (const SheetCurve& curve : plot.curves) {
      std::vector<Canvas::Point> points;
      for (const auto& [px, py] : curve.points) points.push_back(place(px, py));
      canvas.polyline(points, curve.colour, curve.width);
    }
    for (auto curve = plot.curves.rbegin(); curve != plot.curves.rend(); ++curve) {
      if (curve->name.empty()) continue;
      canvas.text(name, at.below + at.height + 5, curve->name, kSmallFont, curve->colour, Align::kRight);
      name -= 7.6 * static_cast<double>(curve->name.size()) + 10;
    }
  }

  static void axes(Canvas& canvas, const SheetPlot& plot, Frame at, const Extent& x, const Extent& y) {
    canvas.text(at.left, at.below + at.height + 5, plot.title, kSmallFont, kInk);
    for (double tick = std::ceil(y.low / stepFor(y.high - y.low)); tick * stepFor(y.high - y.low) <= y.high; ++tick) {
      const double value = tick * stepFor(y.high - y.low);
      const double up = at.below + at.height * y.share(value);
      canvas.line({at.left, up}, {at.left + at.width, up}, kRule, 1);
      canvas.text(at.left - 5, up - 8, numberText(value), kSmallFont, kSoft, Align::kRight);
    }
    canvas.line({at.left, at.below}, {at.left + at.width, at.below}, kSoft, 1);
    const double step = stepFor(x.high - x.low);
    for (double tick = std::ceil(x.low / step); tick * step <= x.high + 1e-9 * step; ++tick) {
      const double across = at.left + at.width * x.share(tick * step);
      canvas.line({across, at.below}, {across, at.below - 4}, kSoft, 1);
      canvas.text(across, at.below - 20, numberText(tick * step), kSmallFont, kSoft, Align::kCentre);
    }
    canvas.text(at.left + at.width / 2, at.below - 36, plot.xLabel, kSmallFont, kSoft, Align::kCentre);
  }

  static void grids(Canvas& canvas, const SheetGrids& all, double below) {
    const double top = below + kGridsHeight;
    canvas.text(kMargin, top - 34, all.title, kHeadFont, kInk, Align::kLeft, true);
    double key = kMargin;
    for (const SheetKey& each : all.key) {
      canvas.box({key, top - 62}, 16, 16, each.colour);
      canvas.text(key + 24, top - 64, each.meaning, kTextFont, kInk);
      key += 60 + 8.3 * static_cast<double>(each.meaning.size());
    }
    const auto columns = static_cast<double>(all.columnNames.size());
    const double foot = below + 58;
    constexpr double kLeft = 88;
    const double apart = (kWidth - 2 * kMargin - kLeft) / static_cast<double>(all.grids.size());
    for (std::size_t j = 0; j < all.rowNames.size(); ++j) {
      canvas.text(kMargin + kLeft - 10, foot + kSquare * static_cast<double>(j) + 5, all.rowNames[j], kSmallFont, kSoft,
                  Align::kRight);
    }
    canvas.upright(kMargin + 14, foot + kSquare * static_cast<double>(all.rowNames.size()) / 2, all.rowLabel,
                   kSmallFont, kSoft);
    for (std::size_t g = 0; g < all.grids.size(); ++g) {
      const double left = kMargin + kLeft + apart * static_cast<double>(g);
      const SheetGrid& grid = all.grids[g];
      canvas.text(left + kSquare * columns / 2, foot + kSquare * static_cast<double>(grid.rows.size()) + 6, grid.title,
                  kTextFont, kInk, Align::kCentre);
      for (std::size_t j = 0; j < grid.rows.size(); ++j) {
        for (std::size_t i = 0; i < grid.rows[j].size(); ++i) {
          canvas.box({left + kSquare * static_cast<double>(i) + 1, foot + kSquare * static_cast<double>(j) + 1},
                     kSquare - 2, kSquare - 2, grid.rows[j][i]);
        }
      }
      for (std::size_t i = 0; i < all.columnNames.size(); ++i) {
        canvas.text(left + kSquare * (static_cast<double>(i) + 0.5), foot - 20, all.columnNames[i], kSmallFont, kSoft,
                    Align::kCentre);
      }
      canvas.text(left + kSquare * columns / 2, foot - 40, all.columnLabel, kSmallFont, kSoft, Align::kCentre);
    }
  }

  void plots(Canvas& canvas, double below) const {
    const double top = below + kPlotsHeight;
    canvas.text(kMargin, top - 34, sheet_->plotsTitle, kHeadFont, kInk, Align::kLeft, true);
    const double apart = (kWidth - 2 * kMargin) / static_cast<double>(sheet_->plots.size());
    for (std::size_t i = 0; i < sheet_->plots.size(); ++i) {
      plot(canvas, sheet_->plots[i],
           {kMargin + kPlotLeft + apart * static_cast<double>(i), below + 52, apart - kPlotLeft - 16, 140});
    }
  }

  const ContactSheet* sheet_ = nullptr;
};

vtkStandardNewMacro(SheetPainter)

}  // namespace

Result<void> drawContactSheet(const ContactSheet& sheet, const std::filesystem::path& png) {
  vtkNew<SheetPainter> painter;
  painter->set(sheet);
  return drawItem(*painter, static_cast<int>(kWidth), SheetPainter::height_px(sheet), sheet.title, png, {});
}

}  // namespace haptics::eval
