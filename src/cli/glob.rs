//! Patterns of paths: `*` and `?` within a part, `**` for any number of parts; letters in any case, as in names.

/// Whether a pattern fits a whole path. Time grows with the product of both lengths, whatever the pattern.
pub fn matches(pattern: &str, path: &str) -> bool {
    let (pattern, path) = (pattern.to_lowercase(), path.to_lowercase());
    let parts = |text: &str| text.split('/').map(|part| part.chars().collect::<Vec<_>>()).collect::<Vec<_>>();
    let within = |pattern: &Vec<char>, part: &Vec<char>| wild(pattern, part, |c| *c == '*', |p, c| *p == '?' || p == c);
    wild(&parts(&pattern), &parts(&path), |part| part == &['*', '*'], within)
}

/// Whether `pattern` fits all of `text`, where some of its items stand for any number of them. Only the last such item is
/// ever tried again: an earlier one that took more would leave less to the last.
fn wild<T>(pattern: &[T], text: &[T], any: impl Fn(&T) -> bool, fits: impl Fn(&T, &T) -> bool) -> bool {
    let (mut p, mut t) = (0, 0);
    let mut last: Option<(usize, usize)> = None;
    while t < text.len() {
        match pattern.get(p) {
            Some(item) if any(item) => {
                last = Some((p, t));
                p += 1;
            }
            Some(item) if fits(item, &text[t]) => (p, t) = (p + 1, t + 1),
            _ => {
                let Some((star, from)) = last else { return false };
                last = Some((star, from + 1));
                (p, t) = (star + 1, from + 1);
            }
        }
    }
    pattern[p..].iter().all(any)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patterns_fit_as_in_a_shell() {
        let fits = [
            ("floor", "Floor"),
            ("floor/*", "floor/oak"),
            ("*", "oak"),
            ("**", "a/b/c"),
            ("**/oak", "oak"),
            ("**/oak", "a/b/oak"),
            ("a/**", "a/b/c"),
            ("a/**/c", "a/c"),
            ("wall_?", "wall_1"),
            ("*a*b", "xaxbab"),
            ("w[1]", "w[1]"),
        ];
        for (pattern, path) in fits {
            assert!(matches(pattern, path), "{pattern} {path}");
        }
        let apart = [
            ("floor/*", "floor"),
            ("floor/*", "floor/a/b"),
            ("*", "a/b"),
            ("wall_?", "wall_"),
            ("*a*b", "xba"),
            ("", "a"),
        ];
        for (pattern, path) in apart {
            assert!(!matches(pattern, path), "{pattern} {path}");
        }
    }

    /// The kind of pattern that takes naive matchers for ever.
    #[test]
    fn no_pattern_takes_long() {
        let (pattern, path) = ("*a".repeat(2000) + "b/**/".repeat(500).as_str(), "a".repeat(4000) + "/a/a/a");
        let start = std::time::Instant::now();
        assert!(!matches(&pattern, &path));
        assert!(!matches(&("**/".repeat(2000) + "b"), &"a/".repeat(2000)));
        assert!(start.elapsed().as_secs() < 5, "{:?}", start.elapsed());
    }
}
