#pragma once

#include <QDialog>
#include <optional>

#include "common/credentials/credentials.h"
#include "common/wire/endpoint.h"
#include "graphics_client/session/recent_servers.h"

class QComboBox;
class QLabel;
class QLineEdit;

namespace haptics {

/// Asks for a server, and for the file of credentials that it may need. What is wrong is said beside its field.
class ConnectDialog : public QDialog {
  Q_OBJECT

 public:
  ConnectDialog(QWidget* parent, const RecentServers& recent);

  struct Choice {
    Endpoint server;
    std::optional<ClientCredentials> credentials;
    RecentServer entry;  ///< As it was typed.
  };
  /// Once the dialog is accepted.
  [[nodiscard]] const std::optional<Choice>& choice() const { return choice_; }

 private:
  const RecentServers recent_;
  QComboBox* address_;
  QLineEdit* credentials_;
  QLabel *addressError_, *credentialsError_;
  std::optional<Choice> choice_;

  void check();
  void browse();
};

}  // namespace haptics
