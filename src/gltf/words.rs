//! JSON that is not what glTF has there, said in the words of JSON and not in those of Rust's types.

use std::path::Path;

use serde::Deserialize;
use serde_json::error::Category;

use crate::error::{Error, Result};

/// The most letters of a wrong value that are shown.
const LONGEST_VALUE: usize = 80;

/// Structs that are read from objects alone, and derive with `remote = "Self"`: serde takes lists for them too, whose
/// items come without names.
macro_rules! objects {
    ($($name:ident),+ $(,)?) => {$(
        impl<'de> serde::Deserialize<'de> for $name {
            fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> std::result::Result<Self, D::Error> {
                struct Object;
                impl<'de> serde::de::Visitor<'de> for Object {
                    type Value = $name;

                    fn expecting(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
                        f.write_str("a map")
                    }

                    fn visit_map<M: serde::de::MapAccess<'de>>(self, map: M) -> std::result::Result<$name, M::Error> {
                        $name::deserialize(serde::de::value::MapAccessDeserializer::new(map))
                    }
                }
                deserializer.deserialize_map(Object)
            }
        }
    )+};
}
pub(crate) use objects;

/// Reads a text; `what` it is comes before the place where it is wrong.
///
/// # Errors
/// [`Error::Invalid`] that names the member at fault, what it is and what it should be.
pub(crate) fn parse<'a, T: Deserialize<'a>>(path: &Path, what: &str, text: &'a str) -> Result<T> {
    serde_json::from_str(text).map_err(|error| {
        if error.classify() != Category::Data {
            return Error::invalid(path, format!("{what}: {error}"), "JSON as in glTF 2.0");
        }
        let (found, expected) = kinds(&error.to_string());
        let found = match place(text, error.line(), error.column()) {
            place if place.is_empty() => format!("{what} that {found}"),
            place => format!("{what} whose {place} {found}"),
        };
        Error::invalid(path, found, expected)
    })
}

/// What was found and what was expected, out of serde's message.
fn kinds(message: &str) -> (String, String) {
    let message = message.rsplit_once(" at line ").map_or(message, |(message, _)| message);
    let (told, expected) = message.rsplit_once(", expected ").unwrap_or((message, ""));
    let expected = match expected {
        "a map" => "an object",
        "a sequence" => "a list",
        "a string" => "a text",
        "a boolean" => "true or false",
        "f32" | "f64" => "a number",
        "u32" => "a whole number from 0 to 4294967295",
        "u64" | "usize" => "a whole number from 0 up",
        _ if expected.starts_with("an array ") => "a list of as many numbers as glTF 2.0 has there",
        _ => "what glTF 2.0 has there",
    };
    let after = |start: &str| told.strip_prefix(start).map(|rest| rest.replace('`', ""));
    let found = if let Some(name) = after("missing field ") {
        format!("has no {name:?}")
    } else if let Some(length) = after("invalid length ") {
        format!("is a list of {length}")
    } else if let Some(found) = after("invalid type: ").or_else(|| after("invalid value: ")) {
        let value =
            ["integer ", "floating point ", "boolean ", "string "].iter().find_map(|kind| found.strip_prefix(kind));
        match (found.as_str(), value) {
            (_, Some(value)) => format!("is {}", short(value)),
            ("map", _) => "is an object".to_owned(),
            ("sequence", _) => "is a list".to_owned(),
            _ => format!("is {found}"),
        }
    } else {
        format!("is wrong ({told})")
    };
    (found, expected.to_owned())
}

/// The beginning of a value, if it is long.
fn short(value: &str) -> String {
    match value.char_indices().nth(LONGEST_VALUE) {
        Some((end, _)) => format!("{}...", &value[..end]),
        None => value.to_owned(),
    }
}

/// The member or item that ends at a place of a text, or that holds it: `materials/0/extensions`. Lines count from 1,
/// columns in bytes.
fn place(text: &str, line: usize, column: usize) -> String {
    let start: usize = text.split_inclusive('\n').take(line.saturating_sub(1)).map(str::len).sum();
    let (bytes, end) = (text.as_bytes(), (start + column).min(text.len()));
    // From the outermost on: keys, or the numbers of items.
    let (mut keys, mut at) = (Vec::new(), 0);
    while at < end {
        match bytes[at] {
            b'"' => {
                let from = at + 1;
                at = from;
                while at < end && bytes[at] != b'"' {
                    at += if bytes[at] == b'\\' { 2 } else { 1 };
                }
                if at < end && text[at + 1..].trim_start().starts_with(':') {
                    keys.pop();
                    keys.push(text[from..at].to_owned());
                }
            }
            b'{' => keys.push(String::new()),
            b'[' => keys.push("0".to_owned()),
            b'}' | b']' => drop(keys.pop()),
            b',' => {
                let next = keys.last().and_then(|key| key.parse::<usize>().ok()).map(|item| (item + 1).to_string());
                next.into_iter().for_each(|next| *keys.last_mut().expect("an item") = next);
            }
            _ => {}
        }
        at += 1;
    }
    keys.retain(|key| !key.is_empty());
    keys.join("/")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gltf::Document;

    fn said(text: &str) -> String {
        parse::<Document>(Path::new("a.gltf"), "JSON", text).unwrap_err().to_string()
    }

    #[test]
    fn what_is_wrong_is_named_by_its_place_and_in_words_of_json() {
        let asset = r#""asset": {"version": "2.0"}"#;
        for (member, found, expected) in [
            (
                r#""materials": [{}, {"name": "a,[\"{", "extensions": null}]"#,
                "materials/1/extensions is null",
                "an object",
            ),
            (r#""materials": "many""#, "materials is \"many\"", "a list"),
            (r#""textures": [{"source": -1}]"#, "textures/0/source is -1", "a whole number from 0 up"),
            ("\n\"materials\":\n [{\"name\": \"é\"}, \n{\"name\": {}}]", "materials/1/name is an object", "a text"),
            (r#""buffers": [{"uri": ""}]"#, "buffers/0 has no \"byteLength\"", "what glTF 2.0 has there"),
            (
                r#""materials": [{"pbrMetallicRoughness": {"roughnessFactor": true}}]"#,
                "materials/0/pbrMetallicRoughness/roughnessFactor is true",
                "a number",
            ),
            (
                r#""textures": [{"extensions": {"EXT_texture_webp": []}}]"#,
                "textures/0/extensions/EXT_texture_webp is a list",
                "an object",
            ),
            (r#""meshes": {}"#, "meshes is an object", "a list"),
            (
                r#""samplers": [{"wrapS": 4294967296}]"#,
                "samplers/0/wrapS is 4294967296",
                "a whole number from 0 to 4294967295",
            ),
        ] {
            let error = said(&format!("{{{asset}, {member}}}"));
            let whole = format!("a.gltf: found JSON whose {found}");
            assert!(error.starts_with(&whole) && error.ends_with(&format!("; expected {expected}")), "{error}");
        }
        assert_eq!(said("[]"), "a.gltf: found JSON that is a list; expected an object");
        assert_eq!(said("{}"), "a.gltf: found JSON that has no \"asset\"; expected what glTF 2.0 has there");
        assert!(said("{").contains("EOF"), "{}", said("{"));
        let long = said(&format!("{{{asset}, \"materials\": \"{}\"}}", "é".repeat(5000)));
        assert_eq!(long, format!("a.gltf: found JSON whose materials is \"{}...; expected a list", "é".repeat(79)));
    }

    /// Serde takes a list for a struct, by the order of its members.
    #[test]
    fn lists_in_the_place_of_objects_are_refused() {
        let asset = r#""asset": {"version": "2.0"}"#;
        for (member, place) in [
            (r#""buffers": [[null, 4]]"#, "buffers/0"),
            (r#""bufferViews": [[0, 0, 4, null]]"#, "bufferViews/0"),
            (r#""materials": [{}, ["n", {}, {"index": 0}, null, {}]]"#, "materials/1"),
            (r#""materials": [{"normalTexture": [0, 0, 1.0, {}]}]"#, "materials/0/normalTexture"),
            (r#""materials": [{"pbrMetallicRoughness": [1, null]}]"#, "materials/0/pbrMetallicRoughness"),
            (r#""textures": [[0, null, {}]]"#, "textures/0"),
            (r#""textures": [{"extensions": {"EXT_texture_webp": [0]}}]"#, "textures/0/extensions/EXT_texture_webp"),
            (r#""images": [[null, 0, "n", "image/png"]]"#, "images/0"),
            (r#""samplers": [[10497, 10497, 9728]]"#, "samplers/0"),
            (r#""meshes": [{"primitives": [[{}, 0, 0, 4, {}]]}]"#, "meshes/0/primitives/0"),
            (r#""nodes": [[0, [], null, null, null, null]]"#, "nodes/0"),
        ] {
            let expected = format!("a.gltf: found JSON whose {place} is a list; expected an object");
            assert_eq!(said(&format!("{{{asset}, {member}}}")), expected);
        }
    }
}
