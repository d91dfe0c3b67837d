//! JSON edited as text: what an edit does not touch keeps its every byte, numbers and unknown members too.
//!
//! Everything here takes text that was parsed before, so that it is known to be JSON; what is not of the kind that is asked
//! for has no members and no items.

use std::fmt::{Formatter, Result as FmtResult};
use std::ops::Range;

use serde::de::{Deserialize, Deserializer, MapAccess, Visitor};
use serde_json::value::RawValue;

/// Members of an object in their order, values as written.
pub(crate) fn members(object: &str) -> Vec<(String, &str)> {
    let members: Members = serde_json::from_str(object).unwrap_or_default();
    members.0.into_iter().map(|(key, value)| (key, value.get())).collect()
}

/// A member of an object.
pub(crate) fn member<'a>(object: &'a str, key: &str) -> Option<&'a str> {
    members(object).into_iter().find_map(|(name, value)| (name == key).then_some(value))
}

/// A member of a member, and so on.
pub(crate) fn at<'a>(object: &'a str, keys: &[&str]) -> Option<&'a str> {
    keys.iter().try_fold(object, |object, key| member(object, key))
}

/// Items of an array.
pub(crate) fn items(array: &str) -> Vec<&str> {
    let items: Vec<&RawValue> = serde_json::from_str(array).unwrap_or_default();
    items.into_iter().map(RawValue::get).collect()
}

/// A string as JSON.
pub(crate) fn quoted(text: &str) -> String {
    serde_json::Value::from(text).to_string()
}

/// An object with some members set, or taken out; new ones come last.
pub(crate) fn with(object: &str, changes: &[(&str, Option<String>)]) -> String {
    let mut all: Vec<(String, String)> =
        members(object).into_iter().map(|(key, value)| (key, value.to_owned())).collect();
    for (key, value) in changes {
        match (all.iter_mut().find(|(name, _)| name == key), value) {
            (Some((_, old)), Some(new)) => *old = new.clone(),
            (None, Some(new)) => all.push(((*key).to_owned(), new.clone())),
            (_, None) => all.retain(|(name, _)| name != key),
        }
    }
    let all: Vec<String> = all.into_iter().map(|(key, value)| format!("{}:{value}", quoted(&key))).collect();
    format!("{{{}}}", all.join(","))
}

/// Changes of a text, made all at once.
pub(crate) struct Edits<'a> {
    text: &'a str,
    list: Vec<(Range<usize>, String)>,
}

impl<'a> Edits<'a> {
    pub fn new(text: &'a str) -> Self {
        Self { text, list: Vec::new() }
    }

    /// Where a part of the text is.
    fn place(&self, part: &str) -> Range<usize> {
        let start = part.as_ptr() as usize - self.text.as_ptr() as usize;
        start..start + part.len()
    }

    /// Puts something else in the place of a part of the text.
    pub fn replace(&mut self, part: &str, new: String) {
        if part != new {
            self.list.push((self.place(part), new));
        }
    }

    /// Adds items to the end of an array; once for each array.
    pub fn append(&mut self, array: &str, new: &[String]) {
        self.insert(array, items(array).last().copied(), new.join(","));
    }

    /// Adds members to the end of an object, as they are written in JSON; once for each object.
    pub fn add(&mut self, object: &str, new: &[(&str, String)]) {
        let new: Vec<String> = new.iter().map(|(key, value)| format!("{}:{value}", quoted(key))).collect();
        self.insert(object, members(object).last().map(|(_, value)| *value), new.join(","));
    }

    /// Takes members out of an object, of which others stay; once for each object.
    pub fn remove(&mut self, object: &str, keys: &[&str]) {
        let start = self.place(object).start + 1;
        let (mut from, mut leading) = (start, true);
        for (key, value) in members(object) {
            let end = self.place(value).end;
            let goes = keys.contains(&key.as_str());
            if goes && !leading {
                self.list.push((from..end, String::new()));
            } else if !goes && leading {
                // What comes before the first that stays goes with its comma.
                let comma = self.text[from..end].find(',').filter(|_| from > start);
                self.list.extend(comma.map(|comma| (start..from + comma + 1, String::new())));
                leading = false;
            }
            from = end;
        }
    }

    fn insert(&mut self, into: &str, after: Option<&str>, new: String) {
        if new.is_empty() {
            return;
        }
        match after {
            Some(last) => {
                let end = self.place(last).end;
                self.list.push((end..end, format!(",{new}")));
            }
            None => {
                let inside = self.place(into).start + 1;
                self.list.push((inside..inside, new));
            }
        }
    }

    /// The text with all changes.
    pub fn apply(mut self) -> String {
        self.list.sort_by_key(|(range, _)| (range.start, range.end));
        let (mut out, mut from) = (String::with_capacity(self.text.len()), 0);
        for (range, new) in &self.list {
            out.push_str(&self.text[from..range.start]);
            out.push_str(new);
            from = range.end;
        }
        out + &self.text[from..]
    }
}

/// A whole number somewhere in a text.
pub(crate) struct Number<'a> {
    /// Of the member that holds it, or that holds the array that does.
    pub key: &'a str,
    /// Whether it is inside an extension that is not known, so that it may be the index of anything.
    pub strange: bool,
    pub value: usize,
}

/// All whole numbers of a text; `known` says which extensions are.
pub(crate) fn numbers<'a>(text: &'a str, known: impl Fn(&str) -> bool) -> Vec<Number<'a>> {
    struct Frame<'a> {
        extensions: bool,
        strange: bool,
        key: &'a str,
        array: bool,
    }
    let bytes = text.as_bytes();
    let (mut stack, mut found, mut at) =
        (vec![Frame { extensions: false, strange: false, key: "", array: true }], Vec::new(), 0);
    while at < bytes.len() {
        let depth = stack.len();
        let top = stack.last_mut().expect("text is balanced");
        let strange = top.strange || (top.extensions && !known(top.key));
        match bytes[at] {
            b'"' => {
                let start = at + 1;
                at = start;
                while bytes[at] != b'"' {
                    at += if bytes[at] == b'\\' { 2 } else { 1 };
                }
                // Strings that are values are taken for keys too, until the next real one.
                if !top.array {
                    top.key = &text[start..at];
                }
            }
            b'{' | b'[' => {
                let array = bytes[at] == b'[';
                let key = if array { top.key } else { "" };
                let extensions = !array && top.key == "extensions";
                stack.push(Frame { extensions, strange, key, array });
            }
            b'}' | b']' if depth > 1 => drop(stack.pop()),
            b'-' | b'0'..=b'9' => {
                let length = bytes[at..].iter().take_while(|b| b"+-.eE0123456789".contains(b)).count();
                let value = whole(&text[at..at + length]);
                found.extend(value.map(|value| Number { key: top.key, strange, value }));
                at += length - 1;
            }
            _ => {}
        }
        at += 1;
    }
    found
}

/// An index, however it is spelt: `1`, `1.0`.
pub(crate) fn whole(text: &str) -> Option<usize> {
    let float = || text.parse::<f64>().ok().filter(|v| v.fract() == 0.0 && (0.0..1e15).contains(v)).map(|v| v as usize);
    text.parse().ok().or_else(float)
}

#[derive(Default)]
struct Members<'a>(Vec<(String, &'a RawValue)>);

impl<'de: 'a, 'a> Deserialize<'de> for Members<'a> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct All;
        impl<'de> Visitor<'de> for All {
            type Value = Members<'de>;

            fn expecting(&self, f: &mut Formatter) -> FmtResult {
                f.write_str("an object")
            }

            fn visit_map<M: MapAccess<'de>>(self, mut map: M) -> Result<Self::Value, M::Error> {
                let mut all = Vec::new();
                while let Some(entry) = map.next_entry()? {
                    all.push(entry);
                }
                Ok(Members(all))
            }
        }
        deserializer.deserialize_map(All)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_is_edited_changes() {
        let text = "{ \"a\" : [ 1.50, 2e3 ],\n \"b\": {\"x\":{}, \"y\" : -0.0}, \"c\" :[] }";
        let mut edits = Edits::new(text);
        edits.append(member(text, "a").unwrap(), &["7".into(), "8".into()]);
        edits.replace(items(member(text, "a").unwrap())[1], "3".into());
        edits.append(member(text, "c").unwrap(), &["9".into()]);
        edits.add(at(text, &["b", "x"]).unwrap(), &[("é\"", "1".into())]);
        edits.add(text, &[("d", "[]".into())]);
        let expected = "{ \"a\" : [ 1.50, 3,7,8 ],\n \"b\": {\"x\":{\"é\\\"\":1}, \"y\" : -0.0}, \"c\" :[9],\"d\":[] }";
        assert_eq!(edits.apply(), expected);
    }

    #[test]
    fn members_go_with_their_commas() {
        let text = r#"{ "a":[","] , "b" : 1, "c":{}, "d": 2 }"#;
        let without = |keys: &[&str]| {
            let mut edits = Edits::new(text);
            edits.remove(text, keys);
            edits.add(text, &[("e", "3".into())]);
            edits.apply()
        };
        assert_eq!(without(&[]), r#"{ "a":[","] , "b" : 1, "c":{}, "d": 2,"e":3 }"#);
        assert_eq!(without(&["a"]), r#"{ "b" : 1, "c":{}, "d": 2,"e":3 }"#);
        assert_eq!(without(&["a", "b", "d"]), r#"{ "c":{},"e":3 }"#);
        assert_eq!(without(&["c", "d"]), r#"{ "a":[","] , "b" : 1,"e":3 }"#);
    }

    #[test]
    fn objects_keep_the_members_that_are_not_set() {
        let object = r#"{"z": 1.0e0, "source": 3, "extras" : {"q":[1, 2]}}"#;
        let changed = with(object, &[("source", None), ("z", Some("2".into())), ("n", Some("{}".into()))]);
        assert_eq!(changed, r#"{"z":2,"extras":{"q":[1, 2]},"n":{}}"#);
    }

    #[test]
    fn numbers_of_strange_extensions_are_told_apart() {
        let text = r#"{"textures":[{"source":1,"extensions":{"KHR_known":{"source":2},"VENDOR_x":{"a":[3,{"b":4}],"c":-5,
            "d":6.5,"e\"{":"7 \\"}}}], "extensions":{"VENDOR_y":8,"KHR_known":9}, "extras":{"extensions":[10]}}"#;
        let all = numbers(text, |name| name.starts_with("KHR_"));
        let strange: Vec<_> = all.iter().filter(|number| number.strange).map(|number| number.value).collect();
        assert_eq!(strange, [3, 4, 8]);
        let sources: Vec<_> = all.iter().filter(|number| number.key == "source").map(|number| number.value).collect();
        assert_eq!(sources, [1, 2]);
        assert!(all.iter().any(|number| number.key == "a" && number.value == 3));
    }

    #[test]
    fn deep_nesting_is_no_danger() {
        let deep = format!("{{\"extensions\":{{\"X\":{}1{}}}}}", "[".repeat(200_000), "]".repeat(200_000));
        assert_eq!(numbers(&deep, |_| false).iter().map(|number| number.value).collect::<Vec<_>>(), [1]);
        assert_eq!(members(&deep).len(), 1);
    }
}
