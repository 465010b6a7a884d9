// IEEE arithmetic that Vulkan does not promise: it lets a quotient be off by 2.5 units in the last place.

// a / b of normal positive numbers whose quotient is normal too, rounded to nearest, ties to even.
float quotient(float a, float b) {
    uint bits_a = floatBitsToUint(a), bits_b = floatBitsToUint(b);
    uint ma = bits_a & 0x7fffffu | 0x800000u, mb = bits_b & 0x7fffffu | 0x800000u;
    // So that q is in [2^23, 2^24).
    bool less = ma < mb;
    uint64_t numerator = uint64_t(ma) << (less ? 24 : 23);
    // A few units off; the remainder tells how many.
    uint q = uint(float(ma) / float(mb) * (less ? 16777216.0 : 8388608.0));
    int64_t rest = int64_t(numerator) - int64_t(q) * int64_t(mb);
    for (int k = 0; k < 16 && rest < 0; k++) {
        q--;
        rest += mb;
    }
    for (int k = 0; k < 16 && rest >= int64_t(mb); k++) {
        q++;
        rest -= mb;
    }
    if (2 * rest > int64_t(mb) || (2 * rest == int64_t(mb) && (q & 1) == 1)) {
        q++;
    }
    uint exponent = (bits_a >> 23) - (bits_b >> 23) + 127 - uint(less);
    // A q of 2^24 carries into the exponent.
    return uintBitsToFloat((exponent << 23) + (q - 0x800000u));
}
