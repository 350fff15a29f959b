#pragma once
// Numbers as people write and read them.
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace tetloom::app {

/// "8G", "500M", "1.5GiB", "4096": bytes, where K, M, G and T stand for powers of 1024. None for anything else, for 0
/// and for what does not fit in 64 bits.
std::optional<std::uint64_t> parse_bytes(std::string_view text);

/// "1.4 GiB".
std::string format_bytes(double bytes);
/// "12,345,678".
std::string format_count(std::uint64_t count);
/// "12.3k", "4.56M": three significant digits, for rates and progress.
std::string format_short(double value);
/// "0.12 s", "12.3 s", "3 min 20 s", "2 h 5 min".
std::string format_seconds(double seconds);
/// Six significant digits without trailing zeros.
std::string format_number(double value);
/// "12.3 %", and enough digits to tell small shares from 0 and large ones from 1.
std::string format_share(double share);

}  // namespace tetloom::app
