// mujoco_guests HOST:PORT table.xml [SECONDS [HZ [LATE_MS [MASS_KG]]]]: bodies that MuJoCo moves are felt through a running
// server, whose scene has objects of their names, and get what the hand does to them. HZ: exchanges with the server a second. LATE_MS:
// forces come so much later, to try it. MASS_KG: of the bodies in place of their own. Prints a line of JSON for each at the end.
#include <haptics/client.h>
#include <haptics/guest_port.h>
#include <mujoco/mujoco.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <deque>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

using haptics::Client;
using haptics::GuestPort;
using Clock = std::chrono::steady_clock;
using Seconds = std::chrono::duration<double>;
using Vector = Client::Vector;

namespace {

constexpr double kStiffness_N_per_m = 400;  // of the objects in table.scene

/// Ticks as they come, for whoever takes them, so much later.
class LateTicks {
 public:
  explicit LateTicks(double late_s) : late_(std::chrono::duration_cast<Clock::duration>(Seconds(late_s))) {}
  void put(const Client::Tick& tick) {
    const std::lock_guard lock(mutex_);
    ticks_.push_back({Clock::now() + late_, tick});
  }
  template <class Take>
  void take(const Take& take) {
    const std::lock_guard lock(mutex_);
    for (; !ticks_.empty() && ticks_.front().due <= Clock::now(); ticks_.pop_front()) take(ticks_.front().tick);
  }

 private:
  struct Due {
    Clock::time_point due;
    Client::Tick tick;
  };
  Clock::duration late_;
  std::mutex mutex_;
  std::deque<Due> ticks_;
};

struct Guest {
  int body;
  std::string name;
  GuestPort port;
  double told_N = 0, table_N = 0;  // upright, sums over the last second
};

Vector vectorAt(const mjtNum* numbers) { return {numbers[0], numbers[1], numbers[2]}; }
Vector minus(const Vector& a, const Vector& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }

/// Moves the body under what the hand does to it, for an exchange.
void act(const mjModel& model, mjData& data, Guest& guest) {
  const GuestPort::Wrench& wrench = guest.port.exchange();
  const Vector arm = minus(wrench.place_m, vectorAt(data.xipos + 3 * guest.body));
  mjtNum* const applied = data.xfrc_applied + 6 * guest.body;
  for (int i = 0; i < 3; ++i) applied[i] = wrench.force_N[static_cast<std::size_t>(i)];
  mju_cross(applied + 3, arm.data(), wrench.force_N.data());
  const double arm2 = arm[0] * arm[0] + arm[1] * arm[1] + arm[2] * arm[2];
  mjtNum* const damping = model.dof_damping + model.body_dofadr[guest.body];
  for (int i = 0; i < 3; ++i) {
    damping[i] = wrench.damping_Ns_per_m;
    damping[i + 3] = wrench.damping_Ns_per_m * arm2;
  }
}

/// What the table gives it upwards.
double tableForce_N(const mjModel& model, const mjData& data, int body) {
  double sum_N = 0;
  for (int i = 0; i < data.ncon; ++i) {
    mjtNum force[6];
    mj_contactForce(&model, &data, i, force);
    const mjContact& contact = data.contact[i];
    if (model.geom_bodyid[contact.geom1] == body || model.geom_bodyid[contact.geom2] == body)
      sum_N += std::abs(force[0] * contact.frame[2]);
  }
  return sum_N;
}

void run(const std::vector<std::string>& arguments) {
  const auto number = [&](std::size_t i, double usual) {
    return arguments.size() > i ? std::stod(arguments[i]) : usual;
  };
  const double seconds = number(2, 10), rate_Hz = number(3, 500), late_s = 1e-3 * number(4, 0), mass_kg = number(5, 0);

  char error[1000] = "";
  const std::unique_ptr<mjModel, void (*)(mjModel*)> model(
      mj_loadXML(arguments.at(1).c_str(), nullptr, error, sizeof error), mj_deleteModel);
  if (!model) throw std::runtime_error(error);
  const std::unique_ptr<mjData, void (*)(mjData*)> data(mj_makeData(model.get()), mj_deleteData);

  LateTicks ticks(late_s);
  Client client({.server = arguments.at(0), .name = "mujoco_guests", .onTick = [&](const Client::Tick& tick) {
                   ticks.put(tick);
                 }});
  std::vector<Guest> guests;
  for (const Client::Body& felt : client.state().bodies) {
    const int body = mj_name2id(model.get(), mjOBJ_BODY, felt.name.c_str());
    if (body < 0) continue;
    guests.push_back({body, felt.name, GuestPort({felt.number, kStiffness_N_per_m, 1 / rate_Hz, late_s})});
    if (mass_kg == 0) continue;
    const double share = mass_kg / model->body_mass[body];
    model->body_mass[body] = mass_kg;
    for (int i = 0; i < 3; ++i) model->body_inertia[3 * body + i] *= share;
  }
  mj_setConst(model.get(), data.get());
  mj_resetData(model.get(), data.get());
  mj_forward(model.get(), data.get());

  const int exchanges = static_cast<int>(seconds * rate_Hz),
            steps = static_cast<int>(1 / rate_Hz / model->opt.timestep + 0.5);
  const auto began = Clock::now();
  for (int n = 0; n < exchanges; ++n) {
    std::this_thread::sleep_until(began + std::chrono::duration_cast<Clock::duration>(Seconds(n / rate_Hz)));
    ticks.take([&](const Client::Tick& tick) {
      for (Guest& guest : guests) guest.port.add(tick);
    });
    for (Guest& guest : guests) act(*model, *data, guest);
    for (int step = 0; step < steps; ++step) {
      std::vector<Vector> before;
      for (const Guest& guest : guests) before.push_back(vectorAt(data->xipos + 3 * guest.body));
      mj_step(model.get(), data.get());
      mj_kinematics(model.get(), data.get());
      mj_comPos(model.get(), data.get());
      for (std::size_t i = 0; i < guests.size(); ++i) {
        Guest& guest = guests[i];
        const Vector now = vectorAt(data->xipos + 3 * guest.body), arm = minus(guest.port.wrench().place_m, before[i]);
        mjtNum turning[3];
        mju_rotVecQuat(turning, data->qvel + model->body_dofadr[guest.body] + 3, data->xquat + 4 * guest.body);
        const double h = model->opt.timestep;
        guest.port.moved(minus(now, before[i]), {h * turning[0], h * turning[1], h * turning[2]}, arm, h);
      }
    }
    for (Guest& guest : guests) {
      const mjtNum* const at = data->xpos + 3 * guest.body;
      const mjtNum* const turned = data->xquat + 4 * guest.body;
      client.drive(guest.name, vectorAt(at), {turned[0], turned[1], turned[2], turned[3]});
      if (n < exchanges - rate_Hz) continue;
      guest.told_N += guest.port.wrench().force_N[2] / rate_Hz;
      guest.table_N += tableForce_N(*model, *data, guest.body) / rate_Hz;
    }
  }
  for (const Guest& guest : guests) {
    const mjtNum* const speed = data->qvel + model->body_dofadr[guest.body];
    const mjtNum* const at = data->xpos + 3 * guest.body;
    std::printf(
        "{\"body\": \"%s\", \"lowest_J\": %.3g, \"energy_J\": %.3g, \"told_N\": %.4f, \"table_N\": %.4f, "
        "\"weight_N\": %.4f, \"speed_m_per_s\": %.3g, \"at\": [%.5f, %.5f, %.5f]}\n",
        guest.name.c_str(), guest.port.lowest_J(), guest.port.energy_J(), guest.told_N, guest.table_N,
        9.81 * model->body_mass[guest.body], mju_norm3(speed), at[0], at[1], at[2]);
  }
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc < 3) {
    std::fputs("usage: mujoco_guests HOST:PORT table.xml [SECONDS [HZ [LATE_MS [MASS_KG]]]]\n", stderr);
    return 2;
  }
  run({argv + 1, argv + argc});
} catch (const std::exception& failure) {
  std::fprintf(stderr, "mujoco_guests: %s\n", failure.what());
  return 1;
}
