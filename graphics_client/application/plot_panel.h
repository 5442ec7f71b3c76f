#pragma once

#include <QColor>
#include <QWidget>
#include <deque>
#include <vector>

#include "common/error/error.h"

class QwtPlot;
class QwtPlotCurve;
class QwtPlotZoomer;

namespace haptics {

// Qwt's headers are no C++20: this one and its source file get along without it.
/// Curves of the last seconds: force and its parts, depth, energy. Stands still while paused.
class PlotPanel : public QWidget {
  Q_OBJECT

 public:
  PlotPanel();

  struct Sample {
    double time_s;
    double written_N, spring_N, friction_N, texture_N;
    double depth_mm, energy_mJ;
  };
  static constexpr double kShown_s = 10;
  void add(const Sample& sample);
  /// These instead of what was added, in order of time.
  void replace(const std::vector<Sample>& samples);
  void setPaused(bool paused) { paused_ = paused; }
  /// Draws what has been added.
  void refresh();
  /// All of them, below each other, as PDF. Refused: the file cannot be written; one that is there stays then.
  [[nodiscard]] Result<void> save(const QString& file);

 protected:
  /// Another theme has other colours.
  void changeEvent(QEvent* event) override;

 private:
  struct Curve {
    const char* name;
    QColor onLight, onDark;
    double Sample::*value;
    QwtPlotCurve* drawn = nullptr;
  };
  struct Plot {
    QwtPlot* plot = nullptr;
    std::vector<Curve> curves;
    QwtPlotZoomer* zoomer = nullptr;
  };
  std::vector<Plot> plots_;
  std::deque<Sample> samples_;
  bool paused_ = false;

  void color();
  void addPlot(const QString& title, const QString& unit, std::vector<Curve> curves);
};

}  // namespace haptics
