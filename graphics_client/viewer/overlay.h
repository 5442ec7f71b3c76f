#pragma once

#include <array>
#include <optional>
#include <vector>

#include "graphics_client/mirror/mirror_view.h"
#include "graphics_client/viewer/camera_fit.h"
#include "graphics_client/viewer/friction_legend.h"
#include "graphics_client/viewer/object_labels.h"
#include "graphics_client/viewer/render_window.h"
#include "graphics_client/viewer/text_panel.h"

namespace haptics {

/// What lies over the picture: status and contact at the top, legend and keys at the bottom, the close-up's frame with
/// its scale, the objects' names, and the banner when something is wrong.
class Overlay {
 public:
  Overlay(RenderWindow& renderWindow, bool showKeys);

  struct State {
    double age_s = 0;  ///< Of the view's sample, now.
    double framesPerSecond = 0;
    double gridSpacing_m = 0;
    double closeUpMetresPerPixel = 0;
    std::optional<FrictionRange> friction = {};  ///< That the surfaces' colours run over.
    std::optional<CoarseDetail> coarse = {};     ///< The surface drawn farthest from what is felt.
    bool pitsFeltAsBumps = false;
    bool wasLive = false, stateWasReset = false;
  };
  /// Text is refreshed some times a second only: it is costly to draw and unreadable when faster.
  void update(const MirrorView& view, const State& state, double time_s);

  /// What the panels and the close-up leave to the scene: the picture's full width between them, or its full height.
  [[nodiscard]] std::array<PictureArea, 2> freeAreas();

  /// The objects' names, wherever the world's camera has moved them.
  void label(const std::vector<NamedBox>& objects);

  void refresh() { refreshed_s_ = -1; }  ///< The next update is not put off.
  void toggle();                         ///< Everything but the banner.
  void toggleHelp();
  void toggleLabels() { labelsVisible_ = !labelsVisible_; }
  void toggleDetails();  ///< What few need of the status.
  [[nodiscard]] bool isVisible() const { return visible_; }
  [[nodiscard]] bool isHelpVisible() const { return helpVisible_; }
  [[nodiscard]] bool areLabelsVisible() const { return labelsVisible_; }
  [[nodiscard]] bool areDetailsVisible() const { return detailsVisible_; }

  /// What the line at a pixel (from the lower left corner) means; empty: there is none.
  [[nodiscard]] std::string tipAt(double x_px, double y_px) const;

 private:
  RenderWindow& renderWindow_;
  TextPanel status_, contact_, legend_, keys_;
  FrictionLegend frictionLegend_;
  ObjectLabels labels_;
  PanelBackground bannerBackground_;
  vtkNew<vtkTextActor> bannerText_, closeUpCaption_, scaleCaption_;
  vtkNew<vtkActor2D> closeUpFrame_;
  PanelBackground scaleBar_;
  Banner shownBanner_;
  bool visible_ = true, helpVisible_, labelsVisible_ = true, detailsVisible_;
  double refreshed_s_ = -1;

  void setLegend(const MirrorView& view, double gridSpacing_m);
  void showBanner(const Banner& banner, double font_px);
  void placeCards(double font_px);
  void placeCloseUpFrame(double metresPerPixel, double font_px);
};

}  // namespace haptics
