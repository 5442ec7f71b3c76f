#include "tests/eval/figure/canvas.h"

#include <vtkBrush.h>
#include <vtkContext2D.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPen.h>
#include <vtkRect.h>
#include <vtkTextProperty.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace haptics::eval {
namespace {

unsigned char byteOf(double share) { return static_cast<unsigned char>(std::lround(255 * share)); }
float narrow(double value) { return static_cast<float>(value); }

}  // namespace

void Canvas::pen(Colour colour, double width) {
  vtkPen* pen = context_.GetPen();
  pen->SetLineType(vtkPen::SOLID_LINE);
  pen->SetColor(byteOf(colour.red), byteOf(colour.green), byteOf(colour.blue));
  pen->SetOpacity(255);
  pen->SetWidth(narrow(width));
}

void Canvas::fill(Colour colour) {
  context_.GetPen()->SetLineType(vtkPen::NO_PEN);
  context_.GetBrush()->SetColor(byteOf(colour.red), byteOf(colour.green), byteOf(colour.blue));
  context_.GetBrush()->SetOpacity(255);
}

void Canvas::text(double x, double y, const std::string& words, int size, Colour colour, Align align, bool bold) {
  vtkTextProperty* property = context_.GetTextProp();
  property->SetFontFamilyToArial();
  property->SetFontSize(size);
  property->SetBold(bold);
  property->SetOrientation(0);
  property->SetColor(colour.red, colour.green, colour.blue);
  property->SetVerticalJustificationToBottom();
  if (align == Align::kLeft) property->SetJustificationToLeft();
  if (align == Align::kCentre) property->SetJustificationToCentered();
  if (align == Align::kRight) property->SetJustificationToRight();
  context_.DrawString(narrow(x), narrow(y), words.c_str());
}

double Canvas::textWidth(const std::string& words, int size, bool bold) {
  vtkTextProperty* property = context_.GetTextProp();
  property->SetFontFamilyToArial();
  property->SetFontSize(size);
  property->SetBold(bold);
  property->SetOrientation(0);
  std::array<float, 4> bounds{};  // left, below, width, height
  context_.ComputeStringBounds(words.c_str(), bounds.data());
  return static_cast<double>(bounds[2]);
}

void Canvas::upright(double x, double y, const std::string& words, int size, Colour colour) {
  vtkTextProperty* property = context_.GetTextProp();
  property->SetFontFamilyToArial();
  property->SetFontSize(size);
  property->SetBold(false);
  property->SetOrientation(90);
  property->SetColor(colour.red, colour.green, colour.blue);
  property->SetJustificationToCentered();
  property->SetVerticalJustificationToCentered();
  context_.DrawString(narrow(x), narrow(y), words.c_str());
}

void Canvas::line(Point from, Point to, Colour colour, double width, bool dashed) {
  pen(colour, width);
  if (dashed) context_.GetPen()->SetLineType(vtkPen::DASH_LINE);
  context_.DrawLine(narrow(from.x), narrow(from.y), narrow(to.x), narrow(to.y));
}

void Canvas::polyline(std::span<const Point> points, Colour colour, double width) {
  if (points.size() < 2) return;
  pen(colour, width);
  std::vector<float> places;
  for (const Point p : points) {
    places.push_back(narrow(p.x));
    places.push_back(narrow(p.y));
  }
  context_.DrawPoly(places.data(), static_cast<int>(points.size()));
}

void Canvas::box(Point below, double width, double height, Colour colour) {
  fill(colour);
  context_.DrawRect(narrow(below.x), narrow(below.y), narrow(width), narrow(height));
}

void Canvas::disc(Point centre, double radius, Colour colour) {
  fill(colour);
  context_.DrawEllipse(narrow(centre.x), narrow(centre.y), narrow(radius), narrow(radius));
}

void Canvas::diamond(Point centre, double radius, Colour colour) {
  fill(colour);
  const float x = narrow(centre.x), y = narrow(centre.y), r = narrow(radius);
  std::array<float, 8> corners{x - r, y, x, y - r, x + r, y, x, y + r};
  context_.DrawPolygon(corners.data(), 4);
}

void Canvas::raster(const Raster& picture, Point below, double width, double height) {
  vtkNew<vtkImageData> image;
  image->SetDimensions(picture.width, picture.height, 1);
  image->AllocateScalars(VTK_UNSIGNED_CHAR, 3);
  std::copy(picture.rgb.begin(), picture.rgb.end(), static_cast<std::uint8_t*>(image->GetScalarPointer()));
  context_.DrawImage(vtkRectf(narrow(below.x), narrow(below.y), narrow(width), narrow(height)), image);
}

}  // namespace haptics::eval
