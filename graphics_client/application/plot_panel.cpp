#include "graphics_client/application/plot_panel.h"

#include <qwt_legend.h>
#include <qwt_plot.h>
#include <qwt_plot_curve.h>
#include <qwt_plot_grid.h>
#include <qwt_plot_renderer.h>
#include <qwt_plot_zoomer.h>
#include <qwt_text.h>

#include <QEvent>
#include <QHBoxLayout>
#include <QPageSize>
#include <QPainter>
#include <QPalette>
#include <QPdfWriter>
#include <QSaveFile>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace haptics {
namespace {

constexpr double kText = 0.85;  // of the window's text

/// Okabe's and Ito's colours, which colour-blind people tell apart, darker or lighter where they would be hard to see on a
/// light or dark ground.
const QColor kBlack(0, 0, 0), kWhite(240, 240, 240), kBlue(0, 90, 160), kSkyBlue(86, 180, 233), kVermilion(200, 75, 0),
    kOrange(240, 165, 40), kDarkGreen(0, 115, 85), kGreen(40, 195, 150);

constexpr double kGap_s = 1;
/// Of a plot in a file.
constexpr QSizeF kSaved_mm(200, 120);
/// What the ends of an axis are apart at least, and as a part of its numbers: six digits then tell its marks apart.
constexpr double kMinSpan = 0.01, kMinPart = 1e-4;

/// Interrupted where no sample came for kGap_s.
class CurveWithGaps : public QwtPlotCurve {
 public:
  using QwtPlotCurve::QwtPlotCurve;

  void drawSeries(QPainter* painter, const QwtScaleMap& x, const QwtScaleMap& y, const QRectF& canvas, int from,
                  int to) const override {
    if (to < 0) to = static_cast<int>(dataSize()) - 1;
    for (int i = from + 1; i <= to; ++i) {
      if (sample(i).x() - sample(i - 1).x() <= kGap_s) continue;
      QwtPlotCurve::drawSeries(painter, x, y, canvas, from, i - 1);
      from = i;
    }
    if (from <= to) QwtPlotCurve::drawSeries(painter, x, y, canvas, from, to);
  }
};

}  // namespace

PlotPanel::PlotPanel() {
  setObjectName("plots");
  new QHBoxLayout(this);
  layout()->setContentsMargins(0, 0, 0, 0);
  addPlot("Force", "N",
          {{"written", kBlack, kWhite, &Sample::written_N},
           {"spring", kBlue, kSkyBlue, &Sample::spring_N},
           {"friction", kVermilion, kOrange, &Sample::friction_N},
           {"texture", kDarkGreen, kGreen, &Sample::texture_N}});
  addPlot("Depth", "mm", {{"HIP below IHIP", kBlue, kSkyBlue, &Sample::depth_mm}});
  addPlot("Energy given", "mJ", {{"by all", kDarkGreen, kGreen, &Sample::energy_mJ}});
  color();
}

void PlotPanel::addPlot(const QString& title, const QString& unit, std::vector<Curve> curves) {
  auto* plot = new QwtPlot;
  QFont small = font();
  small.setPointSizeF(kText * small.pointSizeF());
  const auto write = [&](const QString& words) {
    QwtText text(words);
    text.setFont(small);
    return text;
  };
  plot->setTitle(write(title + " (" + unit + ")"));
  for (const int axis : {QwtPlot::yLeft, QwtPlot::xBottom}) plot->setAxisFont(axis, small);
  plot->setMinimumSize(120, 90);
  plot->setToolTip("Drag a rectangle to zoom; right click: back");
  if (curves.size() > 1) {
    auto* legend = new QwtLegend;
    legend->setFont(small);
    plot->insertLegend(legend, QwtPlot::RightLegend);
  }
  auto* grid = new QwtPlotGrid;
  grid->attach(plot);
  for (Curve& curve : curves) {
    curve.drawn = new CurveWithGaps(curve.name);
    curve.drawn->attach(plot);
  }
  layout()->addWidget(plot);
  plots_.push_back({plot, std::move(curves), new QwtPlotZoomer(plot->canvas())});
}

void PlotPanel::color() {
  const bool isDark = palette().color(QPalette::Base).lightnessF() < 0.5;
  for (const Plot& plot : plots_) {
    plot.plot->setCanvasBackground(palette().color(QPalette::Base));
    for (QwtPlotItem* grid : plot.plot->itemList(QwtPlotItem::Rtti_PlotGrid)) {
      static_cast<QwtPlotGrid*>(grid)->setMajorPen(palette().color(QPalette::Mid), 0, Qt::DotLine);
    }
    for (const Curve& curve : plot.curves) curve.drawn->setPen(isDark ? curve.onDark : curve.onLight, 1.4);
    plot.plot->replot();
  }
}

void PlotPanel::changeEvent(QEvent* event) {
  QWidget::changeEvent(event);
  if (event->type() == QEvent::PaletteChange) color();
}

void PlotPanel::add(const Sample& sample) {
  if (paused_) return;
  samples_.push_back(sample);
  while (samples_.front().time_s < sample.time_s - kShown_s) samples_.pop_front();
}

void PlotPanel::replace(const std::vector<Sample>& samples) {
  if (!paused_) samples_.assign(samples.begin(), samples.end());
}

void PlotPanel::refresh() {
  if (paused_ || !isVisible()) return;
  QVector<double> times;
  for (const Sample& sample : samples_) times.push_back(sample.time_s);
  for (const Plot& plot : plots_) {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const Curve& curve : plot.curves) {
      QVector<double> values;
      for (const Sample& sample : samples_) {
        values.push_back(sample.*curve.value);
        low = std::min(low, values.back());
        high = std::max(high, values.back());
      }
      curve.drawn->setSamples(times, values);
    }
    if (plot.zoomer->zoomRectIndex() == 0 && low <= high) {
      const double span = std::max(kMinSpan, kMinPart * std::max(std::abs(low), std::abs(high)));
      plot.plot->setAxisAutoScale(QwtPlot::yLeft);
      if (high - low < span) plot.plot->setAxisScale(QwtPlot::yLeft, (low + high - span) / 2, (low + high + span) / 2);
    }
    if (!times.empty()) plot.plot->setAxisScale(QwtPlot::xBottom, times.back() - kShown_s, times.back());
    plot.plot->replot();
  }
}

Result<void> PlotPanel::save(const QString& file) {
  QSaveFile to(file);
  const auto failed = [&] {
    return refused(file.toStdString(), "cannot be written: " + to.errorString().toStdString());
  };
  if (!to.open(QIODevice::WriteOnly)) return failed();
  QPdfWriter pdf(&to);
  const auto count = static_cast<double>(plots_.size());
  pdf.setPageSize(QPageSize(QSizeF(kSaved_mm.width(), count * kSaved_mm.height()), QPageSize::Millimeter));
  pdf.setPageMargins({});
  QPainter painter(&pdf);
  const QSizeF page(pdf.width(), pdf.height() / count);
  QwtPlotRenderer renderer;
  double top = 0;
  for (const Plot& plot : plots_) {
    renderer.render(plot.plot, &painter, QRectF(QPointF(0, top), page));
    top += page.height();
  }
  painter.end();
  return to.commit() ? Result<void>() : failed();
}

}  // namespace haptics

#include "moc_plot_panel.cpp"
