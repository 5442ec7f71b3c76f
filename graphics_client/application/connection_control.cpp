#include "graphics_client/application/connection_control.h"

#include <QSettings>
#include <utility>

#include "common/log/log.h"
#include "common/text/printable.h"
#include "graphics_client/application/connect_dialog.h"
#include "graphics_client/session/link_notice.h"

namespace haptics {
namespace {

constexpr const char* kRecent = "recent_servers";

RecentServers readRecent() {
  QSettings from("haptics", "graphics_client");
  std::vector<RecentServer> list;
  const int count = from.beginReadArray(kRecent);
  for (int i = 0; i < count; ++i) {
    from.setArrayIndex(i);
    list.push_back(
        {from.value("address").toString().toStdString(), from.value("credentials").toString().toStdString()});
  }
  return RecentServers(list);
}

void write(const RecentServers& recent) {
  QSettings to("haptics", "graphics_client");
  to.beginWriteArray(kRecent, static_cast<int>(recent.list().size()));
  for (std::size_t i = 0; i < recent.list().size(); ++i) {
    to.setArrayIndex(static_cast<int>(i));
    to.setValue("address", QString::fromStdString(recent.list()[i].address));
    to.setValue("credentials", QString::fromStdString(recent.list()[i].credentials));
  }
}

}  // namespace

ConnectionControl::ConnectionControl(QWidget* window, ServerLink& link, SceneFiles& files)
    : window_(window),
      link_(link),
      files_(files),
      notice_(new NoticeBar("connection", "Connect...", "Chooses a server, and the credentials that it may need")),
      recent_(readRecent()) {
  connect(notice_, &NoticeBar::clicked, [this] { askForServer(); });
}

void ConnectionControl::askForServer() {
  auto* dialog = new ConnectDialog(window_, recent_);
  connect(dialog, &QDialog::accepted, this, [this, dialog] {
    const ConnectDialog::Choice choice = *dialog->choice();
    files_.askBeforeLoss("Connecting to " + QString::fromStdString(choice.entry.address),
                         [this, choice] { connectTo(choice.server, choice.credentials, choice.entry); });
  });
  dialog->open();
}

void ConnectionControl::connectTo(const Endpoint& server, std::optional<ClientCredentials> credentials,
                                  RecentServer entry) {
  recent_.add(std::move(entry));
  write(recent_);
  logInfo("connecting to " + server.text());
  link_.connectTo(server, std::move(credentials));
  emit replaced();
}

void ConnectionControl::disconnectFromServer() {
  files_.askBeforeLoss("Disconnecting", [this] {
    link_.disconnect();
    emit replaced();
  });
}

void ConnectionControl::saveLastSeconds() {
  const QString what = "Save the last 10 seconds";
  if (link_.latest()->link != LinkState::kLive) return emit said(what, "there is no connection to a server", true);
  link_.requestDump([this, what](const v1::DumpReply& reply) {
    const bool isWritten = !reply.file().empty();
    const std::string words = isWritten ? reply.file() + " is written on the server's machine" : reply.reason();
    QMetaObject::invokeMethod(this, [this, what, words = QString::fromStdString(printable(words)), isWritten] {
      logInfo((what + ": " + words).toStdString());
      emit said(what, words, !isWritten);
    });
  });
}

void ConnectionControl::refresh(const MirrorView& view, bool isQuiet) {
  const LinkNotice notice = isQuiet ? LinkNotice{} : noticeOf(view);
  notice_->say(QString::fromStdString(notice.text), notice.isRefusal);
}

}  // namespace haptics

#include "moc_connection_control.cpp"
