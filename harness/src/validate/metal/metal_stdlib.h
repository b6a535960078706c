// The part of Metal's standard library that emitted texts use, for a C++17 compiler: the same names, types and layouts, on a
// processor. Source: Metal Shading Language Specification 3.1. Compile with -fsingle-precision-constant: Metal has no double.
#pragma once
#include <cmath>
#include <cstring>

#define vertex
#define fragment
#define constant const
#define device
#define thread

namespace metal {
using uint = unsigned int;
template <class T, int N> struct vec;

// Parts of vectors are calls here, `v.xyz()`: C++ has nothing that behaves as Metal's `v.xyz` in every expression.
#define PART_2(a, b) vec<T, 2> a##b() const { return vec<T, 2>(a, b); }
#define PART_3(a, b, c) vec<T, 3> a##b##c() const { return vec<T, 3>(a, b, c); }
#define LAST_2(M, ...) M(__VA_ARGS__, x) M(__VA_ARGS__, y)
#define LAST_3(M, ...) LAST_2(M, __VA_ARGS__) M(__VA_ARGS__, z)
#define LAST_4(M, ...) LAST_3(M, __VA_ARGS__) M(__VA_ARGS__, w)
// a macro cannot expand itself, so each length has names of its own
#define PAIRS_2(M) M(x, x) M(x, y) M(y, x) M(y, y)
#define PAIRS_3(M) PAIRS_2(M) M(x, z) M(y, z) M(z, x) M(z, y) M(z, z)
#define PAIRS_4(M) PAIRS_3(M) M(x, w) M(y, w) M(z, w) M(w, x) M(w, y) M(w, z) M(w, w)
#define THREE_2(...) LAST_2(PART_3, __VA_ARGS__)
#define THREE_3(...) LAST_3(PART_3, __VA_ARGS__)
#define THREE_4(...) LAST_4(PART_3, __VA_ARGS__)
#define PARTS(n) PAIRS_##n(PART_2) PAIRS_##n(THREE_##n)

/// Operators of a vector, one component at a time. A number stands for a vector of equal components.
#define OPERATOR(op) \
    friend vec operator op(vec a, vec b) { for (int i = 0; i < SIZE; i++) a[i] = a[i] op b[i]; return a; }
#define COMPARISON(op) \
    friend vec<bool, SIZE> operator op(vec a, vec b) { vec<bool, SIZE> r; for (int i = 0; i < SIZE; i++) r[i] = a[i] op b[i]; return r; }
#define MEMBERS(N) \
    static constexpr int SIZE = N; \
    vec(T all = T()) { for (int i = 0; i < N; i++) (*this)[i] = all; } \
    template <class U> explicit vec(vec<U, N> other) { for (int i = 0; i < N; i++) (*this)[i] = static_cast<T>(other[i]); } \
    T& operator[](int i) { return (&x)[i]; } \
    const T& operator[](int i) const { return (&x)[i]; } \
    PARTS(N) \
    vec operator-() const { vec r; for (int i = 0; i < N; i++) r[i] = -(*this)[i]; return r; } \
    OPERATOR(+) OPERATOR(-) OPERATOR(*) OPERATOR(/) OPERATOR(%) OPERATOR(&) OPERATOR(|) \
    COMPARISON(<) COMPARISON(<=) COMPARISON(>) COMPARISON(>=) COMPARISON(==) COMPARISON(!=)

template <class T> struct alignas(2 * sizeof(T)) vec<T, 2> {
    T x, y;
    vec(T a, T b) : x(a), y(b) {}
    MEMBERS(2)
};
template <class T> struct alignas(4 * sizeof(T)) vec<T, 3> {
    T x, y, z;
    vec(T a, T b, T c) : x(a), y(b), z(c) {}
    vec(vec<T, 2> a, T b) : x(a.x), y(a.y), z(b) {}
    vec(T a, vec<T, 2> b) : x(a), y(b.x), z(b.y) {}
    MEMBERS(3)
};
template <class T> struct alignas(4 * sizeof(T)) vec<T, 4> {
    T x, y, z, w;
    vec(T a, T b, T c, T d) : x(a), y(b), z(c), w(d) {}
    vec(vec<T, 2> a, T b, T c) : x(a.x), y(a.y), z(b), w(c) {}
    vec(T a, T b, vec<T, 2> c) : x(a), y(b), z(c.x), w(c.y) {}
    vec(vec<T, 2> a, vec<T, 2> b) : x(a.x), y(a.y), z(b.x), w(b.y) {}
    vec(vec<T, 3> a, T b) : x(a.x), y(a.y), z(a.z), w(b) {}
    MEMBERS(4)
};
using float2 = vec<float, 2>; using float3 = vec<float, 3>; using float4 = vec<float, 4>;
using int2 = vec<int, 2>; using int3 = vec<int, 3>; using int4 = vec<int, 4>;
using uint2 = vec<uint, 2>; using uint3 = vec<uint, 3>; using uint4 = vec<uint, 4>;
using bool2 = vec<bool, 2>; using bool3 = vec<bool, 3>; using bool4 = vec<bool, 4>;
static_assert(sizeof(float2) == 8 && sizeof(float3) == 16 && sizeof(float4) == 16, "Metal's layout");

// one function for numbers and vectors of floats; not templates, so that parts of vectors are accepted too
#define FOR_VECTORS(M) M(float2) M(float3) M(float4)
#define UNARY(name, formula) \
    inline float name(float x) { return formula; } \
    inline float2 name(float2 v) { return float2(name(v.x), name(v.y)); } \
    inline float3 name(float3 v) { return float3(name(v.x), name(v.y), name(v.z)); } \
    inline float4 name(float4 v) { return float4(name(v.x), name(v.y), name(v.z), name(v.w)); }
UNARY(sin, std::sin(x)) UNARY(cos, std::cos(x)) UNARY(tan, std::tan(x)) UNARY(asin, std::asin(x)) UNARY(acos, std::acos(x)) UNARY(atan, std::atan(x))
UNARY(exp, std::exp(x)) UNARY(exp2, std::exp2(x)) UNARY(log, std::log(x)) UNARY(log2, std::log2(x)) UNARY(sqrt, std::sqrt(x)) UNARY(rsqrt, 1.0f / std::sqrt(x))
UNARY(floor, std::floor(x)) UNARY(ceil, std::ceil(x)) UNARY(trunc, std::trunc(x)) UNARY(rint, std::rint(x)) UNARY(fract, x - std::floor(x))
UNARY(abs, std::fabs(x)) UNARY(sign, x > 0.0f ? 1.0f : (x < 0.0f ? -1.0f : 0.0f)) UNARY(saturate, x < 0.0f ? 0.0f : (x > 1.0f ? 1.0f : x))
#define BINARY(name, formula) \
    inline float name(float x, float y) { return formula; } \
    inline float2 name(float2 a, float2 b) { return float2(name(a.x, b.x), name(a.y, b.y)); } \
    inline float3 name(float3 a, float3 b) { return float3(name(a.x, b.x), name(a.y, b.y), name(a.z, b.z)); } \
    inline float4 name(float4 a, float4 b) { return float4(name(a.x, b.x), name(a.y, b.y), name(a.z, b.z), name(a.w, b.w)); }
BINARY(min, std::fmin(x, y)) BINARY(max, std::fmax(x, y)) BINARY(pow, std::pow(x, y)) BINARY(atan2, std::atan2(x, y)) BINARY(fmod, std::fmod(x, y)) BINARY(step, y < x ? 0.0f : 1.0f)
inline int abs(int x) { return x < 0 ? -x : x; }
inline int min(int x, int y) { return x < y ? x : y; }
inline int max(int x, int y) { return x < y ? y : x; }
inline uint min(uint x, uint y) { return x < y ? x : y; }
inline uint max(uint x, uint y) { return x < y ? y : x; }
inline float clamp(float x, float low, float high) { return min(max(x, low), high); }
inline int clamp(int x, int low, int high) { return min(max(x, low), high); }
inline float mix(float a, float b, float t) { return a + (b - a) * t; }
inline float fma(float a, float b, float c) { return std::fma(a, b, c); }
#define OF_VECTORS(V) \
    inline float dot(V a, V b) { float sum = 0.0f; for (int i = 0; i < V::SIZE; i++) sum += a[i] * b[i]; return sum; } \
    inline float length(V a) { return std::sqrt(dot(a, a)); } \
    inline float distance(V a, V b) { return length(a - b); } \
    inline V normalize(V a) { return a * rsqrt(dot(a, a)); } \
    inline V clamp(V x, V low, V high) { return min(max(x, low), high); } \
    inline V mix(V a, V b, V t) { return a + (b - a) * t; }
FOR_VECTORS(OF_VECTORS)
inline float3 cross(float3 a, float3 b) { return float3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x); }
inline float select(float a, float b, bool c) { return c ? b : a; }
inline int select(int a, int b, bool c) { return c ? b : a; }
inline uint select(uint a, uint b, bool c) { return c ? b : a; }
template <class V> struct exactly { using type = V; };
template <class T, int N> vec<T, N> select(vec<T, N> a, typename exactly<vec<T, N>>::type b, vec<bool, N> c) {
    for (int i = 0; i < N; i++) if (c[i]) a[i] = b[i];
    return a;
}
template <int N> bool all(vec<bool, N> v) { for (int i = 0; i < N; i++) if (!v[i]) return false; return true; }
template <int N> bool any(vec<bool, N> v) { for (int i = 0; i < N; i++) if (v[i]) return true; return false; }

/// A matrix by columns.
struct float4x4 {
    float4 columns[4];
    float4x4() = default;
    float4x4(float4 a, float4 b, float4 c, float4 d) : columns { a, b, c, d } {}
    float4& operator[](int i) { return columns[i]; }
    const float4& operator[](int i) const { return columns[i]; }
    friend float4 operator*(float4x4 m, float4 v) { return m[0] * v.x + m[1] * v.y + m[2] * v.z + m[3] * v.w; }
};

/// Texels of a table, as a package stores them.
struct texels {
    enum number { float32, float16, rgb9e5 } as;
    uint channels, width, height, layers;
    const unsigned char* bytes;
    /// How many reads were outside of a texture: Metal leaves open what they return.
    static inline unsigned long outside = 0;

    float4 at(uint x, uint y, uint layer) const {
        if (x >= width || y >= height || layer >= layers) { outside++; return float4(); }
        const size_t place = (static_cast<size_t>(layer) * height + y) * width + x;
        float4 texel(0.0f, 0.0f, 0.0f, 1.0f);
        const uint packed = as == rgb9e5 ? as_bits<uint>(place) : 0;
        for (uint i = 0; i < channels; i++) {
            if (as == float32) texel[i] = as_bits<float>(place * channels + i);
            else if (as == float16) texel[i] = half(as_bits<unsigned short>(place * channels + i));
            // five bits of exponent with a bias of 15, nine bits of each number
            else texel[i] = std::ldexp(static_cast<float>(packed >> (9 * i) & 511), static_cast<int>(packed >> 27) - 24);
        }
        return texel;
    }
    template <class N> N as_bits(size_t place) const {
        N number;
        std::memcpy(&number, bytes + sizeof(N) * place, sizeof(N));
        return number;
    }
    static float half(unsigned short bits) {
        const int exponent = bits >> 10 & 31, fraction = bits & 1023;
        const float size = exponent == 31 ? (fraction ? NAN : INFINITY)
            : exponent ? std::ldexp(static_cast<float>(1024 + fraction), exponent - 25) : std::ldexp(static_cast<float>(fraction), -24);
        return bits >> 15 ? -size : size;
    }
    /// Linear between texels, the edge beyond them, as the packages' one sampler.
    float4 between(float2 place, uint layer) const {
        const float x = place.x * static_cast<float>(width) - 0.5f, y = place.y * static_cast<float>(height) - 0.5f;
        const float left = std::floor(x), top = std::floor(y);
        auto texel = [&](float column, float row) {
            return at(static_cast<uint>(clamp(column, 0.0f, static_cast<float>(width - 1))), static_cast<uint>(clamp(row, 0.0f, static_cast<float>(height - 1))), layer);
        };
        const float4 above = mix(texel(left, top), texel(left + 1.0f, top), float4(x - left));
        const float4 below = mix(texel(left, top + 1.0f), texel(left + 1.0f, top + 1.0f), float4(x - left));
        return mix(above, below, float4(y - top));
    }
};
enum class access { sample, read, write, read_write };
struct sampler {};
struct level { explicit level(float) {} };
template <class T, access A> struct texture2d {
    texels of;
    float4 read(uint2 place, uint = 0) const { return of.at(place.x, place.y, 0); }
    float4 sample(sampler, float2 place, level = level(0.0f)) const { return of.between(place, 0); }
    uint get_width(uint = 0) const { return of.width; }
    uint get_height(uint = 0) const { return of.height; }
};
template <class T, access A> struct texture2d_array {
    texels of;
    float4 read(uint2 place, uint layer, uint = 0) const { return of.at(place.x, place.y, layer); }
    float4 sample(sampler, float2 place, uint layer, level = level(0.0f)) const { return of.between(place, min(layer, of.layers - 1)); }
    uint get_width(uint = 0) const { return of.width; }
    uint get_height(uint = 0) const { return of.height; }
    uint get_array_size() const { return of.layers; }
};
} // namespace metal

template <class To, class From> To as_type(From from) {
    static_assert(sizeof(To) == sizeof(From), "as_type keeps the bits");
    To to;
    std::memcpy(static_cast<void*>(&to), &from, sizeof(To));
    return to;
}
