//! Words, numbers and marks of shader text, each with the space and comments before it, so that text put together again
//! is the text that was read.

/// One token.
#[derive(Clone, Debug)]
pub struct Token {
    /// What it is.
    pub kind: Kind,
    /// As written.
    pub text: String,
    /// Space, line breaks and comments before it.
    pub before: String,
    /// Line of the file, from 1.
    pub line: usize,
}

/// What a token is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Keyword or name.
    Word,
    /// Number with its suffix.
    Number,
    /// Operator or bracket.
    Mark,
    /// After the last token; holds what stands before the end.
    End,
}

const MARKS: [&str; 16] =
    ["->", "==", "!=", "<=", ">=", "&&", "||", "<<", ">>", "+=", "-=", "*=", "/=", "++", "--", "%="];

/// Longest line: a signature stays on one.
const COLUMNS: usize = 160;

/// The tokens of a file of the restricted style, or `line: what is wrong`.
pub fn tokens(text: &str) -> Result<Vec<Token>, String> {
    for (i, line) in text.lines().enumerate() {
        let wrong = if !line.is_ascii() || line.contains(|c: char| c.is_ascii_control()) {
            "only printable ASCII, for old compilers"
        } else if line.ends_with('\\') {
            "a backslash at the end joins lines in GLSL and HLSL"
        } else if line.contains("/*") || line.contains("*/") {
            "comments start with //"
        } else if line.len() > COLUMNS {
            "more than 160 columns"
        } else {
            continue;
        };
        return Err(format!("{}: {wrong}", i + 1));
    }
    let bytes = text.as_bytes();
    let (mut out, mut at, mut line) = (Vec::new(), 0, 1);
    loop {
        let start = at;
        while at < bytes.len() {
            if bytes[at..].starts_with(b"//") {
                while at < bytes.len() && bytes[at] != b'\n' {
                    at += 1;
                }
            } else if bytes[at].is_ascii_whitespace() {
                line += usize::from(bytes[at] == b'\n');
                at += 1;
            } else {
                break;
            }
        }
        let before = text[start..at].to_string();
        let rest = &text[at..];
        let run = |f: fn(char) -> bool| rest.find(|c| !f(c)).unwrap_or(rest.len());
        let (kind, length) = match rest.chars().next() {
            None => {
                out.push(Token { kind: Kind::End, text: String::new(), before, line });
                return Ok(out);
            }
            Some('a'..='z' | 'A'..='Z' | '_') => (Kind::Word, run(|c| c.is_ascii_alphanumeric() || c == '_')),
            Some('0'..='9') => (Kind::Number, number(rest).map_err(|wrong| format!("{line}: {wrong}"))?),
            Some(_) => (Kind::Mark, if MARKS.iter().any(|m| rest.starts_with(m)) { 2 } else { 1 }),
        };
        out.push(Token { kind, text: rest[..length].to_string(), before, line });
        at += length;
    }
}

/// Length of the number that the text starts with: `1`, `1u`, `0x1Fu`, `1.5`, `1.5e-3`, `1e-3`.
fn number(text: &str) -> Result<usize, String> {
    let bytes = text.as_bytes();
    let digits = |from: usize, hex: bool| {
        let is = |b: &u8| if hex { b.is_ascii_hexdigit() } else { b.is_ascii_digit() };
        from + bytes[from..].iter().take_while(|b| is(b)).count()
    };
    let hex = text.starts_with("0x");
    let mut at = digits(if hex { 2 } else { 0 }, hex);
    let whole = at;
    if !hex && bytes.get(at) == Some(&b'.') {
        at = digits(at + 1, false);
    }
    if !hex && bytes.get(at) == Some(&b'e') {
        let sign = usize::from(matches!(bytes.get(at + 1), Some(b'-' | b'+')));
        let end = digits(at + 1 + sign, false);
        if end == at + 1 + sign {
            return Err("an exponent has digits".to_string());
        }
        at = end;
    }
    if at == whole && bytes.get(at) == Some(&b'u') {
        at += 1;
    }
    match bytes.get(at) {
        Some(b) if b.is_ascii_alphanumeric() || *b == b'_' => {
            Err(format!("a number that not every language reads: {}", &text[..=at]))
        }
        _ if at > 1 && whole > 1 && !hex && bytes[0] == b'0' => {
            Err("a leading 0 means octal in GLSL and HLSL".to_string())
        }
        _ => Ok(at),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_comes_back() {
        let text = "// A note.\nlet x: f32 = -1.5e-3 * (a.x + 0x1Fu); // more\n";
        let tokens = tokens(text).unwrap();
        assert_eq!(tokens.iter().map(|t| t.before.clone() + &t.text).collect::<String>(), text);
        assert_eq!(tokens[0].line, 2);
    }

    #[test]
    fn what_languages_read_differently_is_refused() {
        for text in ["1.0f", "1i", "010u", "1.0e", "/* */", "// a \\", "// \u{b5}"] {
            assert!(tokens(text).is_err(), "{text}");
        }
        assert!(["0.5", "0u", "1e-3", "10.", "0xFFu"].iter().all(|t| tokens(t).unwrap()[0].text == *t));
    }
}
