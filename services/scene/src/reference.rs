//! The reference of scene files, `docs/scene.md`, written from the schema: what the page says is
//! what the reader takes.

mod directed;
mod dynamic;
mod facts;
mod keys;
mod sheets;
mod tables;
#[cfg(test)]
mod tests;
mod wrap;

use super::material::presets;
use super::schema::schema_json;
use super::surface_detail::Look;
use cullet_document::check::tell;
use cullet_document::files::MAX_SCENE_BYTES;
use cullet_document::unit::Dimension;
use facts::{Key, anchor, plain, target};
use serde_json::Value as Json;
use std::collections::BTreeSet;
use tables::{Table, table};
use wrap::wrapped;

/// The page: `cullet schema --reference` prints it, `docs/scene.md` is it.
#[must_use]
pub fn reference() -> String {
    let schema = schema_json();
    let mut page = Page { schema, text: String::new(), written: BTreeSet::new() };
    page.units();
    page.section("Document", 2);
    page.presets();
    let sections = std::mem::take(&mut page.text);
    page.beginning(&sections);
    page.text + &sections
}

struct Page {
    schema: &'static Json,
    text: String,
    /// Types that have their section.
    written: BTreeSet<&'static str>,
}

const BEGINNING: &[&str] = &[
    "This page has every key of a scene file with its type, unit, default and bounds. \
     `cullet schema` prints the same as a JSON schema for editors, `cullet new NAME` writes a \
     commented scene to begin with, and `cullet check SCENE` checks a scene without running it.",
    "A scene is a TOML file, alone or as `scene.toml` in a folder of its own, of at most {size} \
     MiB. An unknown key is an error. All errors of a scene are reported together, each with its \
     line, its value and the allowed range; errors of syntax alone. Any value can also be set \
     from the command line, with items of lists called by their `name`: `--set world.seed=2`, \
     `--set 'body.ball.velocity=[20, 0, 0]'`, `--set 'material.granite.young=\"60 GPa\"'`.",
    "An entry of this page is: **`key`** — type \\[SI unit\\]; default; bounds. Where the default \
     is no plain value, the entry says in words what holds without the key. Bounds are in the SI \
     unit. A unit of \\[1\\] marks counts and ratios.",
];

const UNITS: &str = "A key whose type is one of these quantities takes a number in the SI unit, or \
     text with a number and one of the units: `0.006` and `\"6 mm\"` are the same length. The \
     number in a text may be a fraction, as in `\"1/240 s\"`; µ, ², ³, ° and · may be written for \
     u, 2, 3, deg and a space. A ratio may be text in percent. A key whose type is *number* or \
     *integer* takes no text.";

const PRESETS: &str = "A body can name one of these as its `material`, and a `[[material]]` as its \
     `preset`. `cullet materials` prints their values, `cullet materials --json` also the source \
     of each value.";

impl Page {
    fn paragraph(&mut self, text: &str) {
        self.text.push_str(&wrapped(text, "", ""));
        self.text.push('\n');
    }

    fn heading(&mut self, level: usize, text: &str) {
        self.text.push_str(&format!("{} {text}\n\n", "#".repeat(level)));
    }

    fn rows(&mut self, rows: impl IntoIterator<Item = Vec<String>>) {
        for (index, row) in rows.into_iter().enumerate() {
            self.text.push_str(&format!("| {} |\n", row.join(" | ")));
            if index == 0 {
                self.text.push_str(&format!("|{}\n", "---|".repeat(row.len())));
            }
        }
        self.text.push('\n');
    }

    fn beginning(&mut self, sections: &str) {
        self.heading(1, "Scene file reference");
        let how = "<!-- Written by `cullet schema --reference` from services/scene/src/format.rs: \
                   change it there. -->\n\n";
        self.text.push_str(how);
        for paragraph in BEGINNING {
            self.paragraph(&paragraph.replace("{size}", &(MAX_SCENE_BYTES >> 20).to_string()));
        }
        let headings = sections.lines().filter_map(|line| line.strip_prefix("## "));
        let links: Vec<String> =
            headings.map(|heading| format!("[{heading}](#{})", anchor(heading))).collect();
        self.paragraph(&format!("Sections: {}.", links.join(", ")));
    }

    fn units(&mut self) {
        self.heading(2, "Units");
        self.paragraph(UNITS);
        let schema = self.schema.to_string();
        let used = |dimension: &Dimension| {
            schema.contains(&format!("\"x-unit\":\"{}\"", dimension.name()))
        };
        let head = ["quantity", "SI unit", "units in texts"].map(str::to_owned).to_vec();
        let row = |dimension: Dimension| {
            let units = dimension.units().iter().map(|(name, _)| *name);
            let units: Vec<String> =
                units.filter(|name| !name.is_empty()).map(|name| format!("`{name}`")).collect();
            vec![dimension.name().to_owned(), facts::pretty(dimension), units.join(", ")]
        };
        let rows = Dimension::ALL.into_iter().filter(used).map(row);
        self.rows([head].into_iter().chain(rows).collect::<Vec<_>>());
    }

    /// The section of a type, and below it those of the types that its keys name first.
    fn section(&mut self, name: &'static str, level: usize) {
        let Some(table) = table(name).filter(|table| self.written.insert(table.name)) else {
            return;
        };
        let node = if level == 2 && name == "Document" {
            self.schema
        } else {
            &self.schema["$defs"][name]
        };
        self.heading(level, table.heading);
        self.paragraph(&plain(node["description"].as_str().unwrap_or_default()));
        let mut named = Vec::new();
        if let Some(kinds) = node["oneOf"].as_array() {
            for kind in kinds {
                named.extend(self.kind(table, kind, level + 1));
            }
        } else {
            self.example(table, "");
            named = self.keys((table.keys)(None), node);
        }
        if name == "Detail" {
            self.looks();
        }
        let below = if name == "Document" { 2 } else { level + 1 };
        named.into_iter().for_each(|name| self.section(name, below));
    }

    /// A kind of a table that has several.
    fn kind(&mut self, table: &Table, node: &'static Json, level: usize) -> Vec<&'static str> {
        let kind = node["properties"]["kind"]["const"].as_str().unwrap_or_default();
        self.heading(level, &format!("`kind = \"{kind}\"`"));
        self.paragraph(&plain(node["description"].as_str().unwrap_or_default()));
        self.example(table, kind);
        self.keys((table.keys)(Some(kind)), node)
    }

    fn example(&mut self, table: &Table, kind: &str) {
        for (_, example) in table.examples.iter().filter(|(of, _)| *of == kind) {
            self.text.push_str(&format!("```toml\n{example}```\n\n"));
        }
    }

    /// An entry for each key; says which types they name.
    fn keys(&mut self, keys: Vec<&'static str>, node: &'static Json) -> Vec<&'static str> {
        let required = node["required"].as_array().into_iter().flatten();
        let required: BTreeSet<&str> = required.filter_map(Json::as_str).collect();
        let mut named = Vec::new();
        for name in keys {
            let property = &node["properties"][name];
            let key = Key { schema: self.schema, property, required: required.contains(name) };
            let head = format!("**`{name}`** — {}", key.facts());
            self.text.push_str(&wrapped(&head, "- ", "  "));
            self.text.push('\n');
            self.text.push_str(&wrapped(&key.meaning(), "  ", "  "));
            self.text.push('\n');
            let choices = key.choices();
            for (word, meaning) in &choices {
                let line = format!("`{word}`: {}", plain(meaning));
                self.text.push_str(&wrapped(&line, "  - ", "    "));
            }
            if !choices.is_empty() {
                self.text.push('\n');
            }
            named.extend(target(property));
        }
        named
    }

    fn looks(&mut self) {
        self.paragraph("The values of each `look`:");
        let head = "look,edge,length,influence,grid,height,share,ribs,rib_spacing,grain,grain_size";
        let head = head.split(',').map(str::to_owned).collect();
        let row = |(name, look): (&str, Look)| {
            let d = look.detail();
            let fine = [d.edge, d.length, d.influence, d.grid, d.height];
            let more = [d.share, d.ribs, d.rib_spacing, d.grain, d.grain_size];
            let numbers = fine.into_iter().chain(more).map(tell);
            [format!("`{name}`")].into_iter().chain(numbers).collect()
        };
        let rows = [("plain", Look::Plain)].into_iter().chain(Look::ALL).map(row);
        self.rows([head].into_iter().chain(rows).collect::<Vec<_>>());
    }

    fn presets(&mut self) {
        self.heading(2, "Material presets");
        self.paragraph(PRESETS);
        let head = ["name", "material", "bodies of it break"].map(str::to_owned).to_vec();
        let row = |preset: &super::material::Preset| {
            let breaks = if preset.breakable { "yes" } else { "no" };
            vec![format!("`{}`", preset.name), preset.title.to_owned(), breaks.to_owned()]
        };
        self.rows([head].into_iter().chain(presets().iter().map(row)).collect::<Vec<_>>());
        self.text.truncate(self.text.trim_end().len());
        self.text.push('\n');
    }
}
