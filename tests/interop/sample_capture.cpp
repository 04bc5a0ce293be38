// Writes captures for tshark and `servobus-scanner doctor`: the conversations of the golden vectors.
//
//     servobus_sample_capture FILE SCENE [PREFIX]
#include <cstdlib>
#include <fstream>
#include <iostream>

#include "tests/scanner/sample_capture.hpp"

int main(int count, char** words) {
    if (count < 3) {
        std::cerr << "servobus_sample_capture FILE SCENE [PREFIX]\n";
        return EXIT_FAILURE;
    }
    servobus::scanner::test::SampleCapture sample;
    sample.golden(static_cast<unsigned>(std::strtoul(words[2], nullptr, 10)), count > 3 ? words[3] : "");
    std::ofstream file(words[1], std::ios::binary);
    file << sample.text();
    return file.good() ? EXIT_SUCCESS : EXIT_FAILURE;
}
