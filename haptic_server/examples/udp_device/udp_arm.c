/* udp_arm [PORT]: the device of udp_device.c, simulated: a hand that leads a mass round a circle, up and down through the
 * middle of the workspace, against the force. It feels no force that is older than 25 ms.
 *
 * For tests a line on standard input breaks it: "silence MS", "nan MS", "jump MS", "old MS", "garbled MS", "unhomed MS",
 * "buttons BITS"; "rest 1" keeps the hand in one place. Then it prints when that began and when the force that it feels was 0 (CLOCK_MONOTONIC, ns). */
#include <arpa/inet.h>
#include <math.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include "udp_device.h"

#define PERIOD_NS 1000000u
#define FORGET_NS 25000000u
#define STEP_M 2e-5 /* of its encoders */

static volatile sig_atomic_t ended;
static void end(int signal) { ended = signal; }

static uint64_t now_ns(void) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (uint64_t)now.tv_sec * 1000000000u + (uint64_t)now.tv_nsec;
}

/* The mass is dragged by a spring and a damper to the hand, which goes round once in 4 s, and up and down. */
static void move(double position[3], double velocity[3], const double force[3], double t, int resting) {
  const double mass = 0.25, spring = 400, damper = 6, dt = 1e-3;
  const double hand[3] = {0.02 * cos(1.57 * t), 0.02 * sin(1.57 * t), 0.012 * cos(5 * t) - 0.002};
  for (int i = 0; i < 3; ++i) {
    const double towards = resting ? 0 : hand[i];
    velocity[i] += dt / mass * (force[i] + spring * (towards - position[i]) - damper * velocity[i]);
    position[i] += dt * velocity[i];
  }
}

int main(int argc, char** argv) {
  double position[3] = {0.02, 0, 0.02}, velocity[3] = {0, 0, 0}, force[3] = {0, 0, 0};
  char fault[16] = "", line[64];
  uint64_t begun = now_ns(), next = begun, forced = 0, until = 0;
  uint32_t buttons = 0;
  int resting = 0, watching = 0, has_peer = 0, listening = 1;
  struct sockaddr_in address, peer;
  const int sock = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  memset(&address, 0, sizeof address);
  address.sin_family = AF_INET;
  address.sin_port = htons((uint16_t)(argc > 1 ? atoi(argv[1]) : UDP_DEVICE_PORT));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (sock < 0 || bind(sock, (struct sockaddr*)&address, sizeof address) != 0) {
    perror("udp_arm");
    return 1;
  }
  signal(SIGINT, end);
  signal(SIGTERM, end);
  setvbuf(stdout, NULL, _IOLBF, 0);
  setvbuf(stdin, NULL, _IONBF, 0); /* poll() sees no line that a buffer holds */
  puts("ready");
  while (!ended) {
    struct udp_force wanted;
    struct pollfd input = {STDIN_FILENO, POLLIN, 0};
    socklen_t length = sizeof peer;
    const struct timespec at = {(time_t)(next / 1000000000u), (long)(next % 1000000000u)};
    uint64_t now;
    clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &at, NULL);
    now = now_ns();
    next += PERIOD_NS;
    if (now > next + 20 * PERIOD_NS) next = now; /* it was stopped */
    while (recvfrom(sock, &wanted, sizeof wanted, MSG_DONTWAIT, (struct sockaddr*)&peer, &length) == sizeof wanted) {
      memcpy(force, wanted.force_N, sizeof force);
      forced = now;
      has_peer = 1;
    }
    if (now - forced > FORGET_NS) memset(force, 0, sizeof force);
    if (watching && force[0] == 0 && force[1] == 0 && force[2] == 0) {
      printf("zero %llu\n", (unsigned long long)now);
      watching = 0;
    }
    move(position, velocity, force, (double)(now - begun) * 1e-9, resting);
    if (listening && poll(&input, 1, 0) == 1) {
      double value = 0;
      if (!fgets(line, sizeof line, stdin)) {
        listening = 0;
      } else if (sscanf(line, "%15s %lf", fault, &value) == 2) {
        if (strcmp(fault, "rest") == 0) {
          resting = value != 0;
        } else if (strcmp(fault, "buttons") == 0) {
          buttons = (uint32_t)value;
        } else {
          until = now + (uint64_t)(value * 1e6);
          watching = 1;
          printf("%s %llu\n", fault, (unsigned long long)now);
        }
      }
    }
    if (has_peer) {
      struct udp_state state = {now, {0, 0, 0}, buttons, 1};
      size_t size = sizeof state;
      for (int i = 0; i < 3; ++i) state.position_m[i] = STEP_M * round(position[i] / STEP_M);
      if (now < until) {
        if (strcmp(fault, "silence") == 0) continue;
        if (strcmp(fault, "nan") == 0) state.position_m[1] = NAN;
        if (strcmp(fault, "jump") == 0) state.position_m[0] += 0.05;
        if (strcmp(fault, "old") == 0) state.measured_ns -= 100000000u;
        if (strcmp(fault, "garbled") == 0) size -= 5;
        if (strcmp(fault, "unhomed") == 0) state.homed = 0;
      }
      (void)sendto(sock, &state, size, MSG_DONTWAIT, (struct sockaddr*)&peer, sizeof peer);
    }
  }
  return 0;
}
