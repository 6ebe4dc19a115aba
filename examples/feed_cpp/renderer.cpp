// A renderer for `hmdwarp replay --connect`, written from docs/feed.md: a checkered floor and a
// sphere, one ray a pixel. Put your engine in the place of `draw`. With "swing" behind its address
// the sphere moves; a client with --effects soft_motion is sent the velocity of each pixel.
//
//     g++ -O2 -std=c++17 renderer.cpp -lzmq -o renderer     (Debian: apt-get install libzmq3-dev)
//     ./renderer tcp://127.0.0.1:5570
//     hmdwarp replay look-around --scene server --connect 127.0.0.1:5570

#include <zmq.h>

#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <map>
#include <string>
#include <vector>

using Bytes = std::vector<uint8_t>;
static_assert(sizeof(double) == 8 && sizeof(float) == 4, "IEEE 754 is expected");
constexpr uint16_t VERSION = 3, REQUEST = 1, FRAME = 2;
constexpr size_t REQUEST_BYTES = 180, EYE_BYTES = 144, FRAME_BYTES = 80, LENGTHS_BYTES = 8, HEAD_BYTES = 32;

// The feed is little-endian, as all machines are that this example is for.
template <typename T> T get(const uint8_t *from) { T value; std::memcpy(&value, from, sizeof value); return value; }
template <typename T> void put(uint8_t *to, T value) { std::memcpy(to, &value, sizeof value); }

struct Vec { double x, y, z; };
Vec operator+(Vec a, Vec b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
Vec operator-(Vec a, Vec b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
Vec operator*(double s, Vec a) { return {s * a.x, s * a.y, s * a.z}; }
double dot(Vec a, Vec b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
Vec cross(Vec a, Vec b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }

// --- What is drawn: replace it by your engine ----------------------------------------------------

// Light 0..1; distance along the ray, INFINITY for sky; whether it is the sphere.
struct Surface { double red, green, blue, distance; bool moves = false; };
const Vec CENTRE{0, 1.4, -2}, SUN{0.48, 0.8, 0.36};
const double RADIUS = 0.5, TURNS_S = M_PI;
double swing_m = 0;

Surface look(Vec from, Vec along, Vec centre) {
    Surface seen{0.25, 0.45, 0.75, INFINITY};
    if (along.y < 0) {
        double distance = -from.y / along.y;
        Vec at = from + distance * along;
        bool odd = (int64_t(std::floor(at.x)) + int64_t(std::floor(at.z))) & 1;
        double haze = 64 / (64 + dot(at - from, at - from)), shade = haze * (odd ? 0.15 : 0.6);
        seen = {shade + (1 - haze) * seen.red, shade + (1 - haze) * seen.green, shade + (1 - haze) * seen.blue, distance};
    }
    // |from + t along - centre| = RADIUS
    Vec apart = from - centre;
    double a = dot(along, along), b = dot(along, apart), c = dot(apart, apart) - RADIUS * RADIUS;
    double root = b * b - a * c;
    if (root >= 0) {
        double distance = (-b - std::sqrt(root)) / a;
        if (distance > 0 && distance < seen.distance) {
            double light = 0.1 + 0.8 * std::fmax(0, dot((1 / RADIUS) * (from + distance * along - centre), SUN));
            seen = {light, 0.3 * light, 0.2 * light, distance, swing_m > 0};
        }
    }
    return seen;
}

uint8_t srgb(double light) {
    double coded = light <= 0.0031308 ? 12.92 * light : 1.055 * std::pow(light, 1 / 2.4) - 0.055;
    return uint8_t(std::fmin(std::fmax(coded, 0), 1) * 255 + 0.5);
}

uint16_t half(double value) {  // of what has one
    int power; double part = std::frexp(std::fabs(value), &power);
    if (part == 0 || power < -13) return 0;
    return (value < 0 ? 0x8000 : 0) + ((power + 14) << 10) + std::lround((2 * part - 1) * 1024);
}

// Draw one eye: colour is RGBA in sRGB, depth 1 over the metres along the eye's -z, velocity m/s
// along the eye's axes where something moves; null if it is not wished.
void draw(const uint8_t *eye, int64_t time_ns, uint32_t width, uint32_t height, uint8_t *colour, uint8_t *depth,
          uint8_t *velocity) {
    double n[18];
    std::memcpy(n, eye, sizeof n);
    Vec position{n[0], n[1], n[2]}, turn{n[3], n[4], n[5]};
    double phase = TURNS_S * time_ns * 1e-9;
    Vec centre = CENTRE + Vec{swing_m * std::sin(phase), 0, 0}, speed{swing_m * TURNS_S * std::cos(phase), 0, 0};
    Vec back = 2.0 * cross(speed, turn), in_eye = speed + n[6] * back + cross(back, turn);
    const double moves[] = {in_eye.x, in_eye.y, in_eye.z, 1};
    double left = std::tan(n[14]), right = std::tan(n[15]), down = std::tan(n[16]), up = std::tan(n[17]);
    for (uint32_t row = 0; row < height; ++row)
        for (uint32_t column = 0; column < width; ++column) {
            // Through the pixel's centre, -1 along z: then a distance along the ray is one along -z.
            Vec ray{left + (right - left) * (column + 0.5) / width, up + (down - up) * (row + 0.5) / height, -1};
            Vec twice = 2.0 * cross(turn, ray);
            Surface seen = look(position, ray + n[6] * twice + cross(turn, twice), centre);
            *colour++ = srgb(seen.red), *colour++ = srgb(seen.green), *colour++ = srgb(seen.blue), *colour++ = 255;
            put<float>(depth, float(1 / seen.distance));
            depth += 4;
            for (int i = 0; velocity && seen.moves && i < 4; ++i)
                put<uint16_t>(velocity + 8 * (size_t(row) * width + column) + 2 * i, half(moves[i]));
        }
}

// --- The feed ------------------------------------------------------------------------------------

struct Request { Bytes data; int64_t received_ns; };

int64_t now_ns() { return std::chrono::steady_clock::now().time_since_epoch() / std::chrono::nanoseconds(1); }

bool is_request(const Bytes &it) {
    if (it.size() < REQUEST_BYTES || std::memcmp(it.data(), "HWFD", 4)) return false;
    if (get<uint16_t>(&it[4]) != VERSION || get<uint16_t>(&it[6]) != REQUEST) return false;
    uint32_t width = get<uint32_t>(&it[84]), height = get<uint32_t>(&it[88]), eyes = it[92];
    bool sized = width >= 1 && width <= 8192 && height >= 1 && height <= 8192 && eyes >= 1 && eyes <= 2;
    size_t layers = it[97], wish = layers ? 8 + 32 * eyes + 20 * layers : 0;
    // A frame has 2^29 bytes at most: 16 a pixel here.
    return sized && it.size() == REQUEST_BYTES + eyes * EYE_BYTES + wish && uint64_t(eyes) * width * height < 1 << 24;
}

bool wishes(const uint8_t *asked, const char (&name)[16]) {
    const uint8_t *entry = asked + REQUEST_BYTES + asked[92] * (EYE_BYTES + 32) + 8;
    for (int left = asked[97]; left--; entry += 20) if (!std::memcmp(entry, name, 16)) return true;
    return false;
}

Bytes answer(const Request &request) {
    const uint8_t *asked = request.data.data();
    const size_t width = get<uint32_t>(asked + 84), height = get<uint32_t>(asked + 88), eyes = asked[92];
    const size_t pixels = width * height;
    const char velocity[16] = "velocity";
    const size_t further = wishes(asked, velocity) ? 8 * pixels : 0, head_bytes = further ? HEAD_BYTES : 0;
    Bytes frame(FRAME_BYTES + eyes * (EYE_BYTES + LENGTHS_BYTES + head_bytes + 8 * pixels + further));
    uint8_t *to = frame.data();
    int64_t begun_ns = now_ns();
    std::memcpy(to + FRAME_BYTES, asked + REQUEST_BYTES, eyes * EYE_BYTES);  // drawn as requested
    for (size_t eye = 0; eye < eyes; ++eye) {
        put<uint32_t>(to + FRAME_BYTES + eyes * EYE_BYTES + eye * LENGTHS_BYTES, 4 * pixels);
        put<uint32_t>(to + FRAME_BYTES + eyes * EYE_BYTES + eye * LENGTHS_BYTES + 4, 4 * pixels);
        uint8_t *head = to + FRAME_BYTES + eyes * (EYE_BYTES + LENGTHS_BYTES), *pictures = head + eyes * head_bytes;
        uint8_t *colour = pictures + eye * 8 * pixels, *part = further ? pictures + (eyes + eye) * 8 * pixels : nullptr;
        if (further) {
            std::memcpy(head += eye * HEAD_BYTES, velocity, 16);
            head[16] = eye, head[17] = 1;  // four halves a pixel
            std::memcpy(head + 20, asked + 84, 8), put<uint32_t>(head + 28, further);
        }
        const uint8_t *of_eye = asked + REQUEST_BYTES + eye * EYE_BYTES;
        draw(of_eye, get<int64_t>(asked + 28), width, height, colour, colour + 4 * pixels, part);
    }
    int64_t sent_ns = now_ns();
    std::memcpy(to, "HWFD", 4);
    put<uint16_t>(to + 4, VERSION), put<uint16_t>(to + 6, FRAME), put<uint32_t>(to + 8, frame.size());
    std::memcpy(to + 12, asked + 12, 16);  // id, and when it was sent
    put<int64_t>(to + 28, request.received_ns), put<int64_t>(to + 36, sent_ns), put<int64_t>(to + 44, sent_ns - begun_ns);
    std::memcpy(to + 52, asked + 28, 8);   // the instant that was drawn
    std::memcpy(to + 60, asked + 84, 9);   // width, height, eyes
    to[69] = 2, to[70] = 1;                // sRGB bytes, inverse depth
    to[76] = further ? eyes : 0;           // parts of further layers
    return frame;
}

int main(int count, char **words) {
    const char *address = count > 1 ? words[1] : "tcp://127.0.0.1:5570";
    swing_m = count > 2 ? 0.5 : 0;
    void *context = zmq_ctx_new(), *socket = zmq_socket(context, ZMQ_ROUTER);
    int64_t most = 4096;
    int none = 0;
    zmq_setsockopt(socket, ZMQ_MAXMSGSIZE, &most, sizeof most);
    zmq_setsockopt(socket, ZMQ_LINGER, &none, sizeof none);
    if (zmq_bind(socket, address)) return std::fprintf(stderr, "%s: %s\n", address, zmq_strerror(zmq_errno())), 1;
    char bound[256]; size_t length = sizeof bound;
    zmq_getsockopt(socket, ZMQ_LAST_ENDPOINT, bound, &length);
    std::fprintf(stderr, "listening at %s\n", bound);

    std::map<std::string, Request> newest;  // of each client, by its routing id
    for (;;) {
        zmq_pollitem_t item{socket, 0, ZMQ_POLLIN, 0};
        // All that has come is read before the next picture is drawn: older requests are passed over.
        while (zmq_poll(&item, 1, newest.empty() ? -1 : 0) > 0) {
            std::vector<Bytes> parts;
            for (int more = 1; more;) {
                zmq_msg_t part;
                zmq_msg_init(&part);
                if (zmq_msg_recv(&part, socket, 0) < 0) return 1;
                auto *data = static_cast<uint8_t *>(zmq_msg_data(&part));
                if (parts.size() < 3) parts.emplace_back(data, data + zmq_msg_size(&part));
                more = zmq_msg_more(&part);
                zmq_msg_close(&part);
            }
            if (parts.size() == 2 && is_request(parts[1]))
                newest[std::string(parts[0].begin(), parts[0].end())] = {parts[1], now_ns()};
        }
        for (const auto &[client, request] : newest) {
            Bytes frame = answer(request);
            zmq_send(socket, client.data(), client.size(), ZMQ_SNDMORE | ZMQ_DONTWAIT);
            zmq_send(socket, frame.data(), frame.size(), ZMQ_DONTWAIT);
        }
        newest.clear();
    }
}
