// What evaluates the probes of a package by its Metal text: the resources that a host binds, read from a job, and the printed
// results. validate/metal/job.rs writes the job, and the main function that calls the text's entry points.
#pragma once
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <map>
#include <string>
#include <vector>

// last, since Metal's words are macros there
#include "metal_stdlib"

namespace run {
struct probe {
    metal::float2 place; // of the picture, as the vertex shader interpolates it
    metal::float3 wi, wr;
    metal::float3 normal;
    metal::float4 tangent;
    float angle;
    metal::float4 pattern; // zero without patterns
    std::vector<float> mesh; // the uniforms of the mesh's entry points
};
inline std::map<int, metal::texels> textures;
inline std::map<int, std::vector<unsigned char>> bytes;
inline std::map<int, std::vector<float>> uniforms;
inline std::vector<probe> probes;

[[noreturn]] inline void fail(const std::string& why) {
    std::fprintf(stderr, "%s\n", why.c_str());
    std::exit(1);
}

/// The texture of a binding, as whichever type the text wants.
struct texture {
    int binding;
    const metal::texels& of() const {
        const auto found = textures.find(binding);
        if (found == textures.end()) fail("no texture at binding " + std::to_string(binding));
        return found->second;
    }
    template <class T, metal::access A> operator metal::texture2d<T, A>() const { return {of()}; }
    template <class T, metal::access A> operator metal::texture2d_array<T, A>() const { return {of()}; }
};

/// The uniform block of a binding, as the text's structure.
struct buffer {
    int binding;
    template <class Block> operator const Block&() const {
        const std::vector<float>& numbers = uniforms[binding];
        if (numbers.size() * sizeof(float) != sizeof(Block))
            fail("the uniforms of binding " + std::to_string(binding) + " have " + std::to_string(sizeof(Block)) + " bytes in the text and "
                + std::to_string(numbers.size() * sizeof(float)) + " in the manifest");
        return *reinterpret_cast<const Block*>(numbers.data());
    }
};

inline std::vector<float> numbers(std::istream& in, size_t count) {
    std::vector<float> all(count);
    for (float& one : all) in >> one;
    return all;
}

inline metal::float3 three(std::istream& in) {
    const std::vector<float> v = numbers(in, 3);
    return metal::float3(v[0], v[1], v[2]);
}

inline void read(const char* path) {
    std::ifstream in(path);
    size_t count = 0, block = 0;
    int binding = 0, number = 0;
    for (in >> count; count > 0; count--) {
        metal::texels texels{};
        std::string file;
        in >> binding >> number >> texels.channels >> texels.width >> texels.height >> texels.layers >> std::ws;
        std::getline(in, file);
        std::ifstream data(file, std::ios::binary);
        bytes[binding].assign(std::istreambuf_iterator<char>(data), {});
        const size_t wide = number == 0 ? 4 * texels.channels : number == 1 ? 2 * texels.channels : 4;
        if (bytes[binding].size() != wide * texels.width * texels.height * texels.layers) fail(file + ": has another size than its description says");
        texels.as = static_cast<metal::texels::number>(number);
        texels.bytes = bytes[binding].data();
        textures[binding] = texels;
    }
    in >> binding >> block;
    uniforms[binding] = numbers(in, block);
    in >> count >> block;
    for (size_t i = 0; i < count; i++) {
        probe at;
        at.place = metal::float2((2.0f * static_cast<float>(i) + 1.0f) / static_cast<float>(count) - 1.0f, 0.0f);
        at.wi = three(in);
        at.wr = three(in);
        at.normal = three(in);
        const metal::float3 tangent = three(in);
        at.tangent = metal::float4(tangent, numbers(in, 1)[0]);
        at.angle = numbers(in, 1)[0];
        const metal::float3 turn_and_period = three(in);
        at.pattern = metal::float4(turn_and_period, numbers(in, 1)[0]);
        at.mesh = numbers(in, block);
        probes.push_back(at);
    }
    if (!in) fail("the job is incomplete");
}

/// Prints the colours of a probe on one line. A read outside of a texture is an error.
template <class... Colours> void print(const Colours&... colours) {
    (std::printf("%.9g %.9g %.9g ", colours.x, colours.y, colours.z), ...);
    std::printf("\n");
    if (metal::texels::outside) fail("reads outside of a texture");
}
} // namespace run
