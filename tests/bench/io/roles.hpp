// This program in its other roles, each a process of its own. Each prints one line when it is ready, runs until SIGTERM,
// and may print a line of JSON when it ends.
#pragma once

#include <string>
#include <vector>

namespace servobus::bench {

/// `words` are the name of a role and its arguments; returns the exit code.
///
///     spin                                    keeps a core busy
///     sender FROM TO INTERVAL_US CONNECTION   the bare paced sender: sleep to an absolute deadline, send
///     paced-echo FROM TO INTERVAL_US          the same, and the outputs that came last go into what is sent
///     fleet FROM TO COUNT INTERVAL_US         one end of COUNT bare connections between consecutive addresses
///     udp-echo ADDRESS, tcp-echo ADDRESS      sends back what comes
///     tcp-reply ADDRESS REQUEST REPLY         answers each REQUEST octets with REPLY octets, to many peers
///     udp-sink ADDRESS                        counts what comes
///     load HOST RATE ATTRIBUTES               reads RATE attributes a second, ATTRIBUTES with each request
///     originator ...                          see originator_role.hpp
int play(const std::vector<std::string>& words);

}  // namespace servobus::bench
