//! What stands within functions: statements and expressions.

use std::collections::BTreeMap;

use super::{Done, Language, Writer};
use crate::token::Kind;
use crate::words;

impl Writer<'_> {
    /// A block; returns the first word of its last statement.
    pub(super) fn block(&mut self) -> Result<String, String> {
        self.expect("{")?;
        self.scopes.push(BTreeMap::new());
        let mut last = String::new();
        while self.peek() != "}" {
            last = self.peek().to_string();
            self.statement()?;
        }
        self.put();
        self.scopes.pop();
        Ok(last)
    }

    fn statement(&mut self) -> Done {
        match self.peek() {
            "let" | "var" => self.variable()?,
            "return" => {
                self.put();
                self.expression()?;
            }
            "break" | "continue" => self.put(),
            "if" => return self.branch(),
            "for" => return self.repeat(),
            _ => self.assignment()?,
        }
        self.expect(";")
    }

    fn variable(&mut self) -> Done {
        let changeable = self.peek() == "var";
        let line = self.tokens[self.at].line;
        let (name, kind) = if self.language == Language::Wgsl {
            self.put();
            self.declaration()?
        } else {
            // The type takes the place of `let`.
            let before = self.tokens[self.at].before.clone();
            self.out += &before;
            self.at += 1;
            let length = self.out.len();
            let declared = self.declaration()?;
            let space = self.out[length..].len() - self.out[length..].trim_start().len();
            self.out.replace_range(length..length + space, "");
            declared
        };
        if self.scopes.iter().any(|s| s.contains_key(&name)) {
            return self.wrong(format!("`{name}` hides another"));
        }
        if self.peek() == "=" {
            self.put();
            self.expression()?;
        } else if let (true, Some(fields)) = (changeable, self.names.structs.get(&kind)) {
            self.open.push((name.clone(), fields.iter().map(|f| f.0.clone()).collect(), line));
        } else {
            return self.wrong(format!("`{name}` needs a value"));
        }
        self.scopes.last_mut().expect("within a function").insert(name, changeable);
        Ok(())
    }

    fn assignment(&mut self) -> Done {
        let name = self.peek().to_string();
        match self.scopes.iter().rev().find_map(|s| s.get(&name)) {
            Some(true) => self.put(),
            Some(false) => return self.wrong(format!("`{name}` cannot be assigned")),
            None => return self.wrong(format!("a statement expected, not `{name}`")),
        }
        let mut path = Vec::new();
        while self.peek() == "." {
            self.put();
            path.push(self.peek().to_string());
            self.member()?;
        }
        let last = path.last().map_or("", String::as_str);
        let is_field = self.names.structs.values().flatten().any(|f| f.0 == last);
        if last.len() > 1 && !is_field {
            return self.wrong(format!("not every language assigns to `.{last}`"));
        }
        if !["=", "+=", "-=", "*=", "/="].contains(&self.peek()) {
            return self.wrong(format!("`=` expected, not `{}`", self.peek()));
        }
        if let Some(open) = self.open.iter_mut().find(|o| o.0 == name) {
            match path.as_slice() {
                [] => open.1.clear(),
                [field] => drop(open.1.remove(field)),
                _ => {}
            }
        }
        self.put();
        self.expression()
    }

    fn branch(&mut self) -> Done {
        self.put();
        self.expect("(")?;
        self.expression()?;
        self.expect(")")?;
        self.block()?;
        if self.peek() == "else" {
            self.put();
            if self.peek() == "if" {
                return self.branch();
            }
            self.block()?;
        }
        Ok(())
    }

    fn repeat(&mut self) -> Done {
        self.put();
        self.expect("(")?;
        self.scopes.push(BTreeMap::new());
        if self.peek() != "var" {
            return self.wrong("`for (var i: u32 = ...; ...; i = ...)` expected");
        }
        self.variable()?;
        self.expect(";")?;
        self.expression()?;
        self.expect(";")?;
        self.assignment()?;
        self.expect(")")?;
        self.block()?;
        self.scopes.pop();
        Ok(())
    }

    fn member(&mut self) -> Done {
        let name = self.peek();
        let letters = |of: &str| name.len() <= 4 && name.chars().all(|c| of.contains(c));
        if !letters("xyzw") && !letters("rgba") && !self.names.structs.values().flatten().any(|f| f.0 == name) {
            return self.wrong(format!("no such member: `{name}`"));
        }
        self.put();
        Ok(())
    }

    /// Operands and the operators between them. Precedence is left to the languages, which agree but for bitwise
    /// operators: those stand alone within their brackets.
    pub(super) fn expression(&mut self) -> Done {
        const PLAIN: [&str; 13] = ["+", "-", "*", "/", "%", "==", "!=", "<", ">", "<=", ">=", "&&", "||"];
        const BITS: [&str; 5] = ["&", "|", "^", "<<", ">>"];
        let mut used: Vec<String> = Vec::new();
        loop {
            self.operand()?;
            let operator = self.peek().to_string();
            let bits = BITS.contains(&operator.as_str());
            if !bits && !PLAIN.contains(&operator.as_str()) {
                return Ok(());
            }
            let clash = |other: &String| other != &operator && (bits || BITS.contains(&other.as_str()));
            let logic = |other: &String| other != &operator && ["&&", "||"].contains(&other.as_str());
            if used.iter().any(clash) || (["&&", "||"].contains(&operator.as_str()) && used.iter().any(logic)) {
                return self.wrong(format!("brackets about the operands of `{operator}`"));
            }
            used.push(operator);
            self.put();
        }
    }

    fn operand(&mut self) -> Done {
        while ["-", "!", "~"].contains(&self.peek()) {
            self.put();
        }
        let token = &self.tokens[self.at];
        match token.kind {
            Kind::Number => {
                self.put();
                return Ok(());
            }
            Kind::Mark if token.text == "(" => {
                self.put();
                self.expression()?;
                self.expect(")")?;
            }
            Kind::Word if self.ahead(1) == "(" => self.call()?,
            Kind::Word if ["true", "false"].contains(&self.peek()) => {
                self.put();
                return Ok(());
            }
            Kind::Word => {
                let name = self.peek();
                if !self.names.constants.contains(name) && !self.scopes.iter().any(|s| s.contains_key(name)) {
                    return self.wrong(format!("`{name}` is not declared (above)"));
                }
                self.put();
            }
            _ => return self.wrong(format!("a value expected, not `{}`", token.text)),
        }
        while self.peek() == "." {
            self.put();
            self.member()?;
        }
        Ok(())
    }

    fn call(&mut self) -> Done {
        let name = self.peek().to_string();
        let word = if let Some(word) = words::in_language(&words::FUNCTIONS, &name, self.language) {
            word.to_string()
        } else if let Some(word) = words::in_language(&words::DERIVATIVES, &name, self.language) {
            if !self.screen {
                return self.wrong(format!("`{name}` only in files named *_screen.wgsl"));
            }
            word.to_string()
        } else if words::TYPES.iter().any(|t| t[0] == name) && name != "bool" {
            self.type_word(&name)
        } else if self.names.function(&name).is_some() {
            name.clone()
        } else {
            return self.wrong(format!("no function of the style, or declared above: `{name}`"));
        };
        self.put_as(&word);
        self.expect("(")?;
        let mut count = 0;
        while self.peek() != ")" {
            self.expression()?;
            count += 1;
            if self.peek() == "," {
                self.put();
            } else if self.peek() != ")" {
                return self.wrong("`,` or `)` expected");
            }
        }
        self.put();
        let wanted = match self.names.function(&name) {
            Some(function) => function.arguments.len(),
            None if name.starts_with("vec") => count.max(2),
            None if words::TYPES.iter().any(|t| t[0] == name) => 1,
            None => words::arguments(&name),
        };
        if count != wanted { self.wrong(format!("`{name}` with {count} arguments")) } else { Ok(()) }
    }
}
