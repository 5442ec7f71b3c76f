#include "graphics_client/application/theme.h"

#include <QApplication>
#include <QPalette>
#include <QSettings>
#include <QStyle>
#include <QStyleFactory>

namespace haptics {
namespace {

constexpr const char* kKey = "dark";

/// White on it has a contrast of 6.
const QColor kChosen(40, 100, 170);

QPalette lightPalette() {
  QPalette light = QApplication::style()->standardPalette();
  light.setColor(QPalette::Highlight, kChosen);
  return light;
}

/// Contrast of text to ground above 4.5, also where it is disabled to what is beside it.
QPalette darkPalette() {
  const QColor ground(45, 47, 51), base(30, 31, 34), text(232, 232, 232), faint(150, 150, 150), blue(80, 160, 240);
  QPalette dark(text, ground, ground.lighter(150), ground.darker(150), ground.darker(120), text, Qt::white, base,
                ground);
  dark.setColor(QPalette::AlternateBase, ground);
  dark.setColor(QPalette::ToolTipBase, base);
  dark.setColor(QPalette::ToolTipText, text);
  dark.setColor(QPalette::Link, blue);
  dark.setColor(QPalette::Highlight, kChosen);
  dark.setColor(QPalette::HighlightedText, Qt::white);
  dark.setColor(QPalette::Mid, QColor(95, 95, 95));
  for (const auto role : {QPalette::Text, QPalette::WindowText, QPalette::ButtonText}) {
    dark.setColor(QPalette::Disabled, role, faint);
  }
  return dark;
}

}  // namespace

bool isDarkChosen() { return QSettings("haptics", "graphics_client").value(kKey).toBool(); }

void chooseDark(bool on) {
  QSettings("haptics", "graphics_client").setValue(kKey, on);
  QApplication::setStyle(QStyleFactory::create("Fusion"));
  QApplication::setPalette(on ? darkPalette() : lightPalette());
}

void applyTheme() {
  if (isDarkChosen()) return chooseDark(true);
  QApplication::setPalette(lightPalette());
}

QColor errorColor(const QPalette& palette) {
  return palette.color(QPalette::Window).lightnessF() < 0.5 ? QColor(255, 138, 128) : QColor(176, 0, 32);
}

}  // namespace haptics
