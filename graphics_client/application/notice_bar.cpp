#include "graphics_client/application/notice_bar.h"

#include <QHBoxLayout>
#include <QLabel>
#include <QPushButton>

#include "common/log/log.h"

namespace haptics {

NoticeBar::NoticeBar(const QString& name, const QString& button, const QString& tip) : words_(new QLabel) {
  setObjectName(name);
  setAutoFillBackground(true);
  auto* row = new QHBoxLayout(this);
  row->setContentsMargins(8, 3, 8, 3);
  words_->setTextFormat(Qt::PlainText);
  words_->setWordWrap(true);
  auto* act = new QPushButton(button);
  act->setObjectName(name + " button");
  act->setToolTip(tip);
  act->setFocusPolicy(Qt::TabFocus);
  connect(act, &QPushButton::clicked, [this] { emit clicked(); });
  row->addWidget(words_, 1);
  row->addWidget(act);
  hide();
}

void NoticeBar::say(const QString& words, bool isError) {
  if (words == words_->text()) return;
  words_->setText(words);
  QPalette colors = palette();
  colors.setColor(QPalette::Window, isError ? QColor(170, 30, 30) : QColor(250, 215, 110));
  colors.setColor(QPalette::WindowText, isError ? Qt::white : Qt::black);
  setPalette(colors);
  setVisible(!words.isEmpty());
  logInfo((objectName() + ": " + (words.isEmpty() ? "nothing" : words)).toStdString());
}

}  // namespace haptics

#include "common/log/log.h"
#include "moc_notice_bar.cpp"
