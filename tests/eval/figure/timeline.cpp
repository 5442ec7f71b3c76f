#include "tests/eval/figure/timeline.h"

#include <vtkBrush.h>
#include <vtkContext2D.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkPen.h>
#include <vtkTextProperty.h>

#include <algorithm>
#include <cmath>

#include "tests/eval/figure/draw_item.h"

namespace haptics::eval {
namespace {

constexpr double kLeft = 90, kRight = 50, kWidth = 1500, kPanel = 250, kGap = 62, kHeader = 150, kEvents = 110,
                 kFoot = 60;
constexpr double kLine = 26;
constexpr int kTitleFont = 30, kTextFont = 19, kSmallFont = 15, kTicks = 10;
constexpr Colour kInk{0.13, 0.15, 0.18}, kGrid{0.82, 0.84, 0.86};

unsigned char byteOf(double share) { return static_cast<unsigned char>(std::lround(255 * share)); }

class TimelinePainter final : public vtkContextItem {
 public:
  static TimelinePainter* New();
  vtkTypeMacro(TimelinePainter, vtkContextItem) void set(const Timeline& timeline) { timeline_ = &timeline; }

  [[nodiscard]] static int width_px() { return static_cast<int>(kLeft + kWidth + kRight); }
  [[nodiscard]] static int height_px(const Timeline& timeline) {
    return static_cast<int>(kHeader + kEvents + static_cast<double>(timeline.panels.size()) * (kPanel + kGap) + kFoot);
  }

  bool Paint(vtkContext2D* context) override {
    context_ = context;
    double top = height_px(*timeline_) - 50;
    text(kLeft, top, timeline_->title, kTitleFont, kInk);
    for (const std::string& words : timeline_->caption) text(kLeft, top -= kLine, words, kTextFont, kInk);
    double below = height_px(*timeline_) - kHeader - kEvents;
    for (const auto& [at_s, what] : timeline_->events) text(x(at_s) + 5, below + 6, what, kSmallFont, kInk, 90);
    for (const TimePanel& panel : timeline_->panels) {
      below -= kPanel + kGap;
      paint(panel, below + kGap / 2);
    }
    for (int i = 0; i <= kTicks; ++i) {
      const double at_s = timeline_->seconds * i / kTicks;
      text(x(at_s) - 10, below - 2, std::to_string(std::lround(at_s)) + " s", kTextFont, kInk);
    }
    return true;
  }

 private:
  [[nodiscard]] double x(double at_s) const { return kLeft + kWidth * std::clamp(at_s / timeline_->seconds, 0.0, 1.0); }

  void text(double left, double base, const std::string& words, int size, Colour colour, double turned = 0) {
    vtkTextProperty* property = context_->GetTextProp();
    property->SetFontFamilyToArial();
    property->SetFontSize(size);
    property->SetOrientation(turned);
    property->SetColor(colour.red, colour.green, colour.blue);
    property->SetJustificationToLeft();
    property->SetVerticalJustificationToBottom();
    context_->DrawString(static_cast<float>(left), static_cast<float>(base), words.c_str());
  }

  void pen(Colour colour, float width) {
    context_->GetPen()->SetLineType(vtkPen::SOLID_LINE);
    context_->GetPen()->SetColor(byteOf(colour.red), byteOf(colour.green), byteOf(colour.blue));
    context_->GetPen()->SetWidth(width);
  }
  void line(double x0, double y0, double x1, double y1) {
    context_->DrawLine(static_cast<float>(x0), static_cast<float>(y0), static_cast<float>(x1), static_cast<float>(y1));
  }

  void paint(const TimePanel& panel, double below) {
    context_->GetPen()->SetLineType(vtkPen::NO_PEN);
    for (const TimeBand& band : timeline_->bands) {
      context_->GetBrush()->SetColor(byteOf(band.colour.red), byteOf(band.colour.green), byteOf(band.colour.blue));
      context_->DrawRect(static_cast<float>(x(band.from_s)), static_cast<float>(below),
                         static_cast<float>(std::max(1.0, x(band.to_s) - x(band.from_s))), static_cast<float>(kPanel));
    }
    const auto y = [&](double value) {
      const double share = (std::log10(value) - panel.y.low) / (panel.y.high - panel.y.low);
      return below + kPanel * std::clamp(std::isfinite(share) ? share : 0.0, 0.0, 1.0);
    };
    for (int decade = panel.y.low; decade <= panel.y.high; ++decade) {
      pen(kGrid, 1);
      line(kLeft, y(std::pow(10, decade)), kLeft + kWidth, y(std::pow(10, decade)));
      char number[32];
      std::snprintf(number, sizeof number, "%g", std::pow(10, decade));
      text(kLeft - 60, y(std::pow(10, decade)) - 9, number, kTextFont, kInk);
    }
    text(kLeft, below + kPanel + 5, panel.title, kTextFont, kInk);
    double left = kLeft + 620;
    for (const TimeCurve& curve : panel.curves) {
      pen(curve.colour, 1.6F);
      for (std::size_t i = 1; i < curve.points.size(); ++i) {
        line(x(curve.points[i - 1].first), y(curve.points[i - 1].second), x(curve.points[i].first),
             y(curve.points[i].second));
      }
      line(left, below + kPanel + 16, left + 30, below + kPanel + 16);
      text(left + 36, below + kPanel + 5, curve.name, kTextFont, curve.colour);
      left += 60 + 9.2 * static_cast<double>(curve.name.size());
    }
  }

  const Timeline* timeline_ = nullptr;
  vtkContext2D* context_ = nullptr;
};

vtkStandardNewMacro(TimelinePainter)

}  // namespace

Result<void> drawTimeline(const Timeline& timeline, const std::filesystem::path& png,
                          const std::filesystem::path& svg) {
  vtkNew<TimelinePainter> painter;
  painter->set(timeline);
  return drawItem(*painter, TimelinePainter::width_px(), TimelinePainter::height_px(timeline), timeline.title, png,
                  svg);
}

}  // namespace haptics::eval
