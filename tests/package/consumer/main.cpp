// Somebody else's project: it sees what is installed, and nothing else.
#include <cstdio>

#include "drive/xenax.hpp"

int main() {
    const auto model = servobus::drive::xenax_model("75v8s");
    std::printf("%zu parameters\n", model ? model->parameters.size() : 0);
    return model ? 0 : 1;
}
