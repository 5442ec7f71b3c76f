#include <vtkContextActor.h>
#include <vtkContextScene.h>
#include <vtkNew.h>
#include <vtkPNGWriter.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkSVGExporter.h>
#include <vtkWindowToImageFilter.h>

#include <algorithm>
#include <cmath>

#include "tests/eval/figure/draw_item.h"
#include "tests/eval/figure/figure.h"
#include "tests/eval/figure/painter.h"

namespace haptics::eval {

Decades decadesOf(const std::vector<double>& values) {
  double low = std::numeric_limits<double>::infinity();
  double high = 0;
  for (const double v : values) {
    if (!(v > 0) || !std::isfinite(v)) continue;
    low = std::min(low, v);
    high = std::max(high, v);
  }
  if (high == 0) return {0, 1};
  const int from = static_cast<int>(std::floor(std::log10(low)));
  return {from, std::max(from + 1, static_cast<int>(std::ceil(std::log10(high))))};
}

Result<void> drawItem(vtkContextItem& item, int width_px, int height_px, const std::string& title,
                      const std::filesystem::path& png, const std::filesystem::path& svg) {
  vtkNew<vtkContextActor> actor;
  actor->GetScene()->AddItem(&item);
  vtkNew<vtkRenderer> renderer;
  renderer->SetBackground(1, 1, 1);
  renderer->AddActor(actor);
  actor->GetScene()->SetRenderer(renderer);
  vtkNew<vtkRenderWindow> window;
  window->SetOffScreenRendering(1);
  window->SetMultiSamples(8);
  window->SetSize(width_px, height_px);
  window->AddRenderer(renderer);
  window->Render();

  vtkNew<vtkWindowToImageFilter> picture;
  picture->SetInput(window);
  picture->ReadFrontBufferOff();
  vtkNew<vtkPNGWriter> writer;
  writer->SetFileName(png.c_str());
  writer->SetCompressionLevel(9);
  writer->SetInputConnection(picture->GetOutputPort());
  writer->Write();
  if (writer->GetErrorCode() != 0) return refused(png.string(), "cannot be written");

  if (svg.empty()) return {};
  vtkNew<vtkSVGExporter> exporter;
  exporter->SetRenderWindow(window);
  exporter->SetTitle(title.c_str());
  exporter->SetFileName(svg.c_str());
  exporter->Write();
  if (!std::filesystem::exists(svg)) return refused(svg.string(), "cannot be written");
  return {};
}

Result<void> drawFigure(const Figure& figure, const std::filesystem::path& png, const std::filesystem::path& svg) {
  vtkNew<FigurePainter> painter;
  painter->setFigure(figure);
  return drawItem(*painter, FigurePainter::width_px(figure), FigurePainter::height_px(figure), figure.title, png, svg);
}

}  // namespace haptics::eval
