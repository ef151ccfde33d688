# SPDX-License-Identifier: Apache-2.0
# params: text for people, JSON for programs.
scene=$here/scenes/box.xml
"$lumenaut" params "$scene"
"$lumenaut" params "$scene" --json >p.json
json '[v["name"] for v in d["variables"]] == ["slide", "tint.r", "tint.g", "tint.b", "gloss", "shown"]' <p.json
json 'd["variables"][0] == {"name": "slide", "kind": "translate", "group": "slide", "unit": "m", "description": "", "min": -1, "max": 1, "default": 0, "choices": [], "targets": ["cube.to_world"]}' <p.json
json 'd["variables"][1]["group"] == "tint" and d["variables"][5]["choices"] == ["off", "on"]' <p.json
json 'all(set(p) == {"path", "type", "value"} for p in d["parameters"])' <p.json
json '{"cube.to_world", "wall.reflectance.value"} <= {p["path"] for p in d["parameters"]}' <p.json
json 'd["size"] == [48, 32] and d["spp"] == 8 and d["max_depth"] == 4' <p.json
"$lumenaut" params --all "$scene" | grep -q '^metal.alpha.value  float  0.2$'
