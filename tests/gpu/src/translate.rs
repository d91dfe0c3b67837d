//! From the restricted WGSL of `kernels/wgsl` to GLSL and HLSL, token by token: comments, names and lines stay. What is
//! outside of the restricted style, and what another language would read differently, is refused with its line.

use std::collections::{BTreeMap, BTreeSet};

use crate::token::{Kind, Token, tokens};
use crate::words;

mod body;

/// A shader language.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Language {
    /// The hand-written text.
    Wgsl,
    /// 450, 330 and ES 3.00 alike.
    Glsl,
    /// Shader model 5 and up.
    Hlsl,
}

impl Language {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Wgsl, Self::Glsl, Self::Hlsl];

    /// Folder of `kernels` and extension of its files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Wgsl => "wgsl",
            Self::Glsl => "glsl",
            Self::Hlsl => "hlsl",
        }
    }
}

/// A type by its WGSL name.
pub type Type = String;

/// A function's signature.
#[derive(Clone, Debug)]
pub struct Function {
    /// Its name.
    pub name: String,
    /// Names and types of its arguments.
    pub arguments: Vec<(String, Type)>,
    /// What it returns.
    pub result: Type,
}

/// What files before one have declared, and then what it declares itself.
#[derive(Clone, Debug, Default)]
pub struct Names {
    /// Fields of each struct, in order.
    pub structs: BTreeMap<String, Vec<(String, Type)>>,
    /// In order.
    pub functions: Vec<Function>,
    /// Module constants.
    pub constants: BTreeSet<String>,
}

impl Names {
    /// The function of this name.
    pub fn function(&self, name: &str) -> Option<&Function> {
        self.functions.iter().find(|f| f.name == name)
    }

    fn is_type(&self, name: &str) -> bool {
        words::TYPES.iter().any(|t| t[0] == name) || self.structs.contains_key(name)
    }
}

/// The file in `language`, without a heading; `names` gains what it declares. On a `screen` there are derivatives. Errors
/// are `line: what is wrong`.
pub fn translate(text: &str, language: Language, screen: bool, names: &mut Names) -> Result<String, String> {
    let tokens = tokens(text)?;
    let (scopes, open) = (Vec::new(), Vec::new());
    let mut writer = Writer { tokens: &tokens, at: 0, language, screen, out: String::new(), names, scopes, open };
    writer.file()?;
    Ok(writer.out)
}

type Done = Result<(), String>;

struct Writer<'a> {
    tokens: &'a [Token],
    at: usize,
    language: Language,
    screen: bool,
    out: String,
    names: &'a mut Names,
    /// Variables in reach, innermost block last; true where they can be assigned.
    scopes: Vec<BTreeMap<String, bool>>,
    /// Struct variables without a value: name and fields not yet assigned.
    open: Vec<(String, BTreeSet<String>, usize)>,
}

impl Writer<'_> {
    fn peek(&self) -> &str {
        &self.tokens[self.at].text
    }

    fn ahead(&self, by: usize) -> &str {
        &self.tokens[(self.at + by).min(self.tokens.len() - 1)].text
    }

    fn wrong<T>(&self, what: impl std::fmt::Display) -> Result<T, String> {
        Err(format!("{}: {what}", self.tokens[self.at].line))
    }

    /// Writes the next token, as `text` in the other languages.
    fn put_as(&mut self, text: &str) {
        let token = &self.tokens[self.at];
        self.out += &token.before;
        self.out += text;
        self.at += 1;
    }

    fn put(&mut self) {
        let text = self.tokens[self.at].text.clone();
        self.put_as(&text);
    }

    fn expect(&mut self, text: &str) -> Done {
        if self.peek() != text {
            return self.wrong(format!("`{text}` expected, not `{}`", self.peek()));
        }
        self.put();
        Ok(())
    }

    /// Passes the next token over; only space may stand before it, which goes too.
    fn skip(&mut self, text: &str) -> Done {
        let token = &self.tokens[self.at];
        if token.text != text {
            return self.wrong(format!("`{text}` expected, not `{}`", token.text));
        }
        if !token.before.trim().is_empty() || token.before.contains('\n') {
            return self.wrong(format!("nothing but space before `{text}`"));
        }
        self.at += 1;
        Ok(())
    }

    /// A new name.
    fn name(&self, ahead: usize) -> Result<String, String> {
        let token = &self.tokens[(self.at + ahead).min(self.tokens.len() - 1)];
        if token.kind != Kind::Word {
            return self.wrong(format!("a name expected, not `{}`", token.text));
        }
        if let Some(why) = words::taken(&token.text) {
            return self.wrong(format!("`{}` is {why}", token.text));
        }
        Ok(token.text.clone())
    }

    fn type_at(&self, ahead: usize) -> Result<Type, String> {
        let word = self.ahead(ahead);
        if self.names.is_type(word) {
            Ok(word.to_string())
        } else {
            self.wrong(format!("`{word}` is no type of the style"))
        }
    }

    fn type_word(&self, name: &str) -> String {
        words::in_language(&words::TYPES, name, self.language).unwrap_or(name).to_string()
    }

    /// `name: type`, turned round in the other languages; both are returned.
    fn declaration(&mut self) -> Result<(String, Type), String> {
        let name = self.name(0)?;
        if self.ahead(1) != ":" {
            return self.wrong(format!("`{name}` needs a type"));
        }
        let kind = self.type_at(2)?;
        if self.language == Language::Wgsl {
            (0..3).for_each(|_| self.put());
        } else {
            let text = format!("{} {name}", self.type_word(&kind));
            self.put_as(&text);
            self.skip(":")?;
            self.skip(&kind)?;
        }
        Ok((name, kind))
    }

    fn file(&mut self) -> Done {
        loop {
            match self.peek() {
                "struct" => self.structure()?,
                "const" => self.constant()?,
                "fn" => self.function()?,
                "" => {
                    self.put();
                    return Ok(());
                }
                other => return self.wrong(format!("`struct`, `const` or `fn` expected, not `{other}`")),
            }
        }
    }

    fn commented(&self, what: &str) -> Done {
        let before = self.tokens[self.at].before.trim_end_matches(' ');
        let above = before.strip_suffix('\n').and_then(|b| b.rsplit('\n').next());
        if above.is_some_and(|line| line.trim_start().starts_with("//")) {
            return Ok(());
        }
        self.wrong(format!("{what} needs a comment directly above"))
    }

    fn structure(&mut self) -> Done {
        self.commented("a struct")?;
        let name = self.name(1)?;
        if !name.starts_with("Mf") || self.names.is_type(&name) {
            return self.wrong(format!("structs are named MfSomething, once: `{name}`"));
        }
        self.put();
        self.put();
        self.expect("{")?;
        let mut fields: Vec<(String, Type)> = Vec::new();
        while self.peek() != "}" {
            let field = self.declaration()?;
            if fields.iter().any(|f| f.0 == field.0) {
                return self.wrong(format!("field `{}` twice", field.0));
            }
            fields.push(field);
            if self.peek() != "," {
                return self.wrong("every field ends with a comma");
            }
            self.put_as(if self.language == Language::Wgsl { "," } else { ";" });
        }
        self.put_as(if self.language == Language::Wgsl { "}" } else { "};" });
        self.names.structs.insert(name, fields);
        Ok(())
    }

    fn constant(&mut self) -> Done {
        let name = self.name(1)?;
        if !name.starts_with("MF_") || !self.names.constants.insert(name.clone()) {
            return self.wrong(format!("constants are named MF_SOMETHING, once: `{name}`"));
        }
        self.put_as(if self.language == Language::Hlsl { "static const" } else { "const" });
        self.declaration()?;
        self.expect("=")?;
        self.expression()?;
        self.expect(";")
    }

    fn function(&mut self) -> Done {
        self.commented("a function")?;
        let (name, first) = (self.name(1)?, self.tokens[self.at].line);
        if !name.starts_with("mf_") || self.names.function(&name).is_some() {
            return self.wrong(format!("functions are named mf_something, once: `{name}`"));
        }
        let arrow = (self.at..self.tokens.len()).find(|&i| self.tokens[i].text == "->");
        let Some(arrow) = arrow.filter(|&i| self.tokens[i].line == first) else {
            return self.wrong("a signature returns something and stays on one line");
        };
        let result = self.type_at(arrow + 1 - self.at)?;
        if self.language == Language::Wgsl {
            self.put();
            self.put();
        } else {
            let head = format!("{} {name}", self.type_word(&result));
            self.put_as(&head);
            self.skip(&name)?;
        }
        self.expect("(")?;
        let mut arguments = Vec::new();
        while self.peek() != ")" {
            arguments.push(self.declaration()?);
            if self.peek() == "," {
                self.put();
            } else if self.peek() != ")" {
                return self.wrong("`,` or `)` expected");
            }
        }
        self.put();
        if self.language == Language::Wgsl {
            self.expect("->")?;
            self.put();
        } else {
            self.skip("->")?;
            self.skip(&result)?;
        }
        self.scopes = vec![arguments.iter().map(|a| (a.0.clone(), false)).collect()];
        self.open.clear();
        let last = self.block()?;
        if last != "return" {
            return self.wrong(format!("`{name}` ends without `return`"));
        }
        if let Some((variable, fields, line)) = self.open.iter().find(|o| !o.1.is_empty()) {
            return Err(format!("{line}: `{variable}` is never given {fields:?}"));
        }
        self.names.functions.push(Function { name, arguments, result });
        Ok(())
    }
}
