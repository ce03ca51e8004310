// The first and last lines of a report: style and the one script, both inline. Internal to render.
#pragma once

#include <string>
#include <string_view>

namespace turgor {

/// `title`: HTML.
inline std::string report_head(std::string_view title) {
  constexpr std::string_view before =
      R"(<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">
<title>)";
  constexpr std::string_view after = R"(</title>
<style>
:root { --ink: #1d2430; --soft: #5b6675; --line: #dfe3e8; --paper: #ffffff; --tint: #f5f7f9; --accent: #17635f; }
* { box-sizing: border-box; }
body { margin: 0 auto; max-width: 1180px; padding: 28px; color: var(--ink); background: var(--paper);
       font: 15px/1.5 system-ui, -apple-system, "Segoe UI", "Liberation Sans", Arial, sans-serif; }
h1 { margin: 0; font-size: 30px; font-weight: 600; }
h2 { margin: 0 0 12px; font-size: 19px; font-weight: 600; }
header { border-bottom: 2px solid var(--accent); padding-bottom: 14px; }
.brand { margin: 0; color: var(--accent); font-weight: 600; letter-spacing: .04em; }
.facts { margin: 4px 0 0; color: var(--soft); }
.lead { font-size: 17px; }
section { margin: 34px 0; }
.row { display: flex; flex-wrap: wrap; gap: 14px; }
figure { flex: 1 1 240px; max-width: 50%; margin: 0; }
figure.wide { flex-basis: 100%; max-width: 100%; }
figure img { width: 100%; display: block; border: 1px solid var(--line); border-radius: 6px; }
figcaption { color: var(--soft); font-size: 13px; padding: 4px 2px; }
table { border-collapse: collapse; margin: 8px 0; font-variant-numeric: tabular-nums; }
th, td { text-align: left; padding: 5px 14px 5px 0; border-bottom: 1px solid var(--line); vertical-align: top; }
th { color: var(--soft); font-weight: 500; }
pre { background: var(--tint); padding: 12px 14px; border-radius: 6px; overflow: auto; font-size: 13px; }
.good { color: #17635f; font-weight: 600; } .bad { color: #a8321d; font-weight: 600; }
.wipe { position: relative; --at: 50%; }
.wipe .over { position: absolute; inset: 0; clip-path: inset(0 calc(100% - var(--at)) 0 0); }
.wipe::after { content: ""; position: absolute; top: 0; bottom: 0; left: var(--at); width: 2px; background: var(--accent); }
.wipe input { position: absolute; inset: auto 0 6px 0; width: 100%; margin: 0; accent-color: var(--accent); z-index: 1; }
details summary { cursor: pointer; color: var(--soft); }
@media print { .wipe input { display: none; } section { break-inside: avoid-page; } }
</style></head><body>
)";
  return std::string(before).append(title).append(after);
}

inline constexpr std::string_view report_tail = R"(<script>
for (const wipe of document.querySelectorAll('.wipe')) {
  const handle = wipe.querySelector('input');
  handle.addEventListener('input', () => wipe.style.setProperty('--at', handle.value + '%'));
}
</script></body></html>
)";

}  // namespace turgor
