/* The same in C++, for:
     c++ -std=c++17 -O2 lowest_dark.cpp -o lowest_dark
     simtip detect IMAGE --detector "cmd:./lowest_dark {image} {level}" \
         --set image_format=pgm --set level=0.4
*/
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

int main(int argc, char** argv) {
    if (argc < 3) {
        std::fprintf(stderr, "usage: lowest_dark IMAGE.pgm LEVEL\n");
        return 2;
    }
    std::ifstream file(argv[1], std::ios::binary);
    std::string magic;
    int width = 0, height = 0, white = 0;
    file >> magic >> width >> height >> white;
    file.get();  // the one white space after the head
    if (!file || magic != "P5" || width < 1 || height < 1) {
        std::fprintf(stderr, "%s is no binary PGM\n", argv[1]);
        return 1;
    }
    const int bytes = white > 255 ? 2 : 1;  // the high byte first
    std::vector<unsigned char> data(std::size_t(width) * height * bytes);
    if (!file.read(reinterpret_cast<char*>(data.data()), std::streamsize(data.size()))) {
        std::fprintf(stderr, "%s is cut short\n", argv[1]);
        return 1;
    }
    const double level = std::atof(argv[2]) * white;
    for (int v = height - 1; v >= 0; --v) {
        double sum = 0;
        int count = 0;
        for (int u = 0; u < width; ++u) {
            const std::size_t k = (std::size_t(v) * width + u) * bytes;
            const int value = bytes == 2 ? data[k] * 256 + data[k + 1] : data[k];
            if (value < level) {
                sum += u;
                ++count;
            }
        }
        if (count > 0) {
            std::printf("{\"tip_px\": [%.6f, %d]}\n", sum / count, v);
            return 0;
        }
    }
    std::printf("{\"status\": \"not_found\", \"reason\": \"no pixel is below %g DN\"}\n", level);
    return 0;
}
