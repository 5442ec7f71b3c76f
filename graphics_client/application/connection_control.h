#pragma once

#include <QObject>
#include <functional>

#include "graphics_client/application/notice_bar.h"
#include "graphics_client/application/scene_files.h"
#include "graphics_client/mirror/server_link.h"
#include "graphics_client/session/recent_servers.h"

class QWidget;

namespace haptics {

/// Which server the window shows: connects to another one, disconnects, and says over the picture what is wrong with
/// the connection.
class ConnectionControl : public QObject {
  Q_OBJECT

 public:
  ConnectionControl(QWidget* window, ServerLink& link, SceneFiles& files);

  /// Over the picture.
  [[nodiscard]] NoticeBar* notice() { return notice_; }
  /// Asks for a server, and connects to it once edits that are in no file are dealt with.
  void askForServer();
  void disconnectFromServer();
  /// The server writes what it felt last to a file of its own.
  void saveLastSeconds();
  /// @param isQuiet  Another source is shown than the server.
  void refresh(const MirrorView& view, bool isQuiet);

 signals:
  /// The link is to another server, or to none.
  void replaced();
  void said(const QString& what, const QString& words, bool isError);

 private:
  QWidget* window_;
  ServerLink& link_;
  SceneFiles& files_;
  NoticeBar* notice_;
  RecentServers recent_;

  void connectTo(const Endpoint& server, std::optional<ClientCredentials> credentials, RecentServer entry);
};

}  // namespace haptics
