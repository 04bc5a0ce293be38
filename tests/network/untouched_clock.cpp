// Preloaded into ptp4l by time_sync_test.py: the clock of the machine is not for a test to change, and where ptp4l may not
// change it, it never becomes a slave. So it believes that it has. It reads the clock by other calls.
#include <sys/timex.h>

#include <ctime>

extern "C" {

int clock_adjtime(clockid_t /*clock*/, struct timex* /*settings*/) noexcept { return TIME_OK; }

int adjtimex(struct timex* /*settings*/) noexcept { return TIME_OK; }

int clock_settime(clockid_t /*clock*/, const struct timespec* /*time*/) noexcept { return 0; }

}  // extern "C"
