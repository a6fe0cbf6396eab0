//! Names that every format takes: letters, digits and underscores, each once.

use std::collections::BTreeSet;

/// Names that were given.
#[derive(Debug, Default)]
pub(crate) struct UniqueNames {
    taken: BTreeSet<String>,
}

impl UniqueNames {
    /// A name for `text` that no other has: `pot.0.11` becomes `pot_0_11`.
    pub(crate) fn give(&mut self, text: &str) -> String {
        let plain = identifier(text);
        let numbered = (2..).map(|n| format!("{plain}_n{n}"));
        let all = std::iter::once(plain.clone()).chain(numbered);
        let free = all.into_iter().find(|name| !self.taken.contains(name)).unwrap_or(plain);
        self.taken.insert(free.clone());
        free
    }
}

/// An identifier as USD has it: ASCII letters, digits and underscores, no digit first.
fn identifier(text: &str) -> String {
    let fits = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
    let mut name: String = text.chars().map(fits).collect();
    if name.chars().next().is_none_or(|c| c.is_ascii_digit()) {
        name.insert(0, '_');
    }
    name
}

#[cfg(test)]
mod tests {
    use super::UniqueNames;

    #[test]
    fn names_are_identifiers_and_differ() {
        let mut names = UniqueNames::default();
        let given = ["pot.0.11", "pot-0.11", "pot_0_11_n2", "9 mm", "", "größe"];
        let given = given.map(|text| names.give(text));
        let wanted = ["pot_0_11", "pot_0_11_n2", "pot_0_11_n2_n2", "_9_mm", "_", "gr__e"];
        assert_eq!(given, wanted);
    }
}
