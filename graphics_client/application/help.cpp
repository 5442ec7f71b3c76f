#include "graphics_client/application/help.h"

#include <QDialog>
#include <QDialogButtonBox>
#include <QFile>
#include <QMenu>
#include <QMenuBar>
#include <QMessageBox>
#include <QRegularExpression>
#include <QTextBrowser>
#include <QVBoxLayout>

/// A macro that does not work within a namespace.
static void initPages() { Q_INIT_RESOURCE(help); }

namespace haptics {
namespace {

constexpr const char* kMouse[][2] = {
    {"left button", "on an object: the hand presses there; click: selects it"},
    {"wheel", "nearer, farther; with the left button down: presses harder, more lightly"},
    {"Ctrl + wheel", "opens, closes the gripper of the hand that you lead, of a device that has one"},
    {"right button", "turns the picture"},
    {"middle button", "moves the picture"},
    {"Shift + left button", "turns the hand that touches, of a device that turns"},
    {"pen", "presses as hard as the pen does"},
};

QString row(const QString& key, const QString& title, const QString& does) {
  return QString("<tr><td><b>%1</b>&nbsp;&nbsp;</td><td>%2&nbsp;&nbsp;</td><td>%3</td></tr>")
      .arg(key.toHtmlEscaped(), title.toHtmlEscaped(), does.toHtmlEscaped());
}

QString plain(QString title) { return title.remove('&'); }

QString rowsOf(const QMenu* menu) {
  QString rows;
  for (const QAction* action : menu->actions()) {
    if (action->isSeparator()) continue;
    if (action->menu() != nullptr) {
      rows += rowsOf(action->menu());
      continue;
    }
    QString title = plain(action->text());
    if (title.startsWith("Undo") || title.startsWith("Redo")) title = title.left(4);
    rows += row(QKeySequence::listToString(action->shortcuts(), QKeySequence::NativeText), title, action->statusTip());
  }
  return rows;
}

/// Shows a page; one of each kind at a time.
QTextBrowser* page(QMainWindow* window, const QString& title) {
  if (auto* open = window->findChild<QDialog*>(title)) delete open;
  auto* dialog = new QDialog(window);
  dialog->setObjectName(title);
  dialog->setWindowTitle(title);
  dialog->setAttribute(Qt::WA_DeleteOnClose);
  auto* text = new QTextBrowser;
  text->setAccessibleName(title);
  text->setOpenExternalLinks(true);
  auto* buttons = new QDialogButtonBox(QDialogButtonBox::Close);
  QObject::connect(buttons, &QDialogButtonBox::rejected, dialog, &QDialog::reject);
  auto* rows = new QVBoxLayout(dialog);
  rows->addWidget(text);
  rows->addWidget(buttons);
  dialog->resize(QSize(820, 640).boundedTo(window->size() - QSize(40, 40)));
  dialog->show();
  return text;
}

}  // namespace

void showKeys(QMainWindow* window) {
  QString html = "<table><tr><td colspan=3><h3>Mouse</h3></td></tr>";
  for (const auto& [what, does] : kMouse) html += row(what, does, "");
  for (const QAction* menu : window->menuBar()->actions()) {
    if (menu->menu() == nullptr) continue;
    html += QString("<tr><td colspan=3><h3>%1</h3></td></tr>").arg(plain(menu->text())) + rowsOf(menu->menu());
  }
  page(window, "Keys")->setHtml(html + "</table>");
}

void showGuide(QMainWindow* window) {
  initPages();
  QFile file(":/clients.md");
  if (!file.open(QIODevice::ReadOnly)) return;
  QString markdown = QString::fromUtf8(file.readAll());
  const int from = markdown.indexOf("\n## The viewer\n"), to = markdown.indexOf("\n## ", from + 4);
  markdown = markdown.mid(from, to - from);
  markdown.remove(QRegularExpression(R"( *!\[[^\]]*\]\([^)]*\)\n)"));               // pictures, which are not here
  markdown.replace(QRegularExpression(R"(\[([^\]]*)\]\((?!http)[^)]*\))"), "\\1");  // nor are other pages
  page(window, "Guide")->setMarkdown(markdown);
}

void showAbout(QMainWindow* window) {
  auto* about = new QMessageBox(
      QMessageBox::Information, "About",
      "<b>Haptic viewer " HAPTICS_VERSION
      "</b><p>Shows and edits the scene of a haptic_server, whose contact is after "
      "C. Ho, C. Basdogan and M. A. Srinivasan, <i>Efficient Point-Based Rendering Techniques for Haptic Display of "
      "Virtual Objects</i>, Presence 8(5), 1999.</p><p>Drawn by VTK, with Qt and Qwt.</p><p>F1: keys. Shift+F1: "
      "guide.</p>",
      QMessageBox::Close, window);
  about->setAttribute(Qt::WA_DeleteOnClose);
  about->open();
}

}  // namespace haptics
