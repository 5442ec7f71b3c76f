#pragma once

#include <QMainWindow>

namespace haptics {

/// What the mouse does, and every action of the window's menus with its keys.
void showKeys(QMainWindow* window);
/// The viewer's page.
void showGuide(QMainWindow* window);
void showAbout(QMainWindow* window);

}  // namespace haptics
