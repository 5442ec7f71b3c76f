#include "graphics_client/application/connect_dialog.h"

#include <QComboBox>
#include <QDialogButtonBox>
#include <QFileDialog>
#include <QGridLayout>
#include <QLabel>
#include <QLineEdit>
#include <QPushButton>
#include <utility>

#include "common/log/log.h"
#include "common/text/printable.h"

namespace haptics {
namespace {

QLabel* errorLabel(const QString& name) {
  auto* label = new QLabel;
  label->setObjectName(name);
  label->setTextFormat(Qt::PlainText);
  label->setWordWrap(true);
  QPalette colors = label->palette();
  colors.setColor(QPalette::WindowText, errorColor(colors));
  label->setPalette(colors);
  label->hide();
  return label;
}

void say(QLabel* label, const std::optional<Error>& error) {
  label->setVisible(error.has_value());
  if (!error) return label->clear();
  label->setText(QString::fromStdString(printable(error->text())));
  logWarning("connect: " + label->text().toStdString());
}

}  // namespace

ConnectDialog::ConnectDialog(QWidget* parent, const RecentServers& recent)
    : QDialog(parent),
      recent_(recent),
      address_(new QComboBox),
      credentials_(new QLineEdit),
      addressError_(errorLabel("address error")),
      credentialsError_(errorLabel("credentials error")) {
  setWindowTitle("Connect");
  setAttribute(Qt::WA_DeleteOnClose);
  address_->setObjectName("address");
  address_->setEditable(true);
  address_->setInsertPolicy(QComboBox::NoInsert);
  address_->setToolTip("HOST:PORT of a haptic_server; the list holds those that you connected to last");
  for (const RecentServer& server : recent_.list()) address_->addItem(QString::fromStdString(server.address));
  if (recent_.list().empty()) address_->setEditText("127.0.0.1:7654");
  credentials_->setObjectName("credentials");
  credentials_->setToolTip("The viewer.credentials or editor.credentials of a server that has some; empty: none");
  auto* browse = new QPushButton("Browse...");
  browse->setToolTip("Chooses the file");
  browse->setAutoDefault(false);
  connect(browse, &QPushButton::clicked, [this] { this->browse(); });
  const auto fillIn = [this](const QString& address) {
    credentials_->setText(QString::fromStdString(recent_.credentialsOf(address.toStdString())));
  };
  connect(address_, &QComboBox::currentTextChanged, [this, fillIn](const QString& address) {
    if (address_->findText(address) >= 0) fillIn(address);
  });
  fillIn(address_->currentText());

  auto* buttons = new QDialogButtonBox(QDialogButtonBox::Cancel);
  auto* connecting = buttons->addButton("Co&nnect", QDialogButtonBox::AcceptRole);
  connect(buttons, &QDialogButtonBox::accepted, [this] { check(); });
  connect(buttons, &QDialogButtonBox::rejected, [this] { reject(); });

  auto* form = new QGridLayout(this);
  const auto addLabel = [&](const QString& words, QWidget* field, int row) {
    auto* label = new QLabel(words);
    label->setBuddy(field);
    form->addWidget(label, row, 0);
  };
  addLabel("&Server", address_, 0);
  form->addWidget(address_, 0, 1, 1, 2);
  form->addWidget(addressError_, 1, 1, 1, 2);
  addLabel("C&redentials", credentials_, 2);
  form->addWidget(credentials_, 2, 1);
  form->addWidget(browse, 2, 2);
  form->addWidget(credentialsError_, 3, 1, 1, 2);
  form->addWidget(buttons, 4, 0, 1, 3);
  form->setColumnStretch(1, 1);
  resize(480, 0);
  connecting->setDefault(true);  // within the dialog by now
  address_->setFocus();
  address_->lineEdit()->selectAll();
}

void ConnectDialog::check() {
  const RecentServer entry{address_->currentText().trimmed().toStdString(),
                           credentials_->text().trimmed().toStdString()};
  const auto server = parseEndpoint(entry.address);
  say(addressError_, server ? std::nullopt : std::optional(server.error()));
  std::optional<ClientCredentials> credentials;
  std::optional<Error> wrong;
  if (!entry.credentials.empty()) {
    auto read = readClientCredentials(entry.credentials);
    if (read) {
      credentials = *std::move(read);
    } else {
      wrong = std::move(read).error();
    }
  }
  say(credentialsError_, wrong);
  if (!server || wrong) return;
  choice_ = Choice{*server, std::move(credentials), entry};
  accept();
}

void ConnectDialog::browse() {
  const QString file =
      QFileDialog::getOpenFileName(this, "Credentials", credentials_->text(), "Credentials (*.credentials);;All (*)");
  if (!file.isEmpty()) credentials_->setText(file);
}

}  // namespace haptics

#include "moc_connect_dialog.cpp"
