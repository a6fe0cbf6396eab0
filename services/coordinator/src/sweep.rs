//! Sweeps: one scene with many settings, as a file of lists and ranges.
//!
//! ```toml
//! scene = "../pot"                              # relative to this file
//! set = ["fracture.max_particles=2000"]         # for every run
//!
//! [product]                                     # every combination
//! "world.seed" = [1, 2, 3]
//! "body.pot.thickness" = { from = 2, to = 6, count = 5, unit = "mm" }
//!
//! [[zip]]                                       # these go on together
//! "body.floor.material" = ["granite", "steel"]
//! "world.impulse_threshold" = [0.1, 0.2]
//! ```

use serde::Deserialize;
use std::collections::BTreeSet;
use toml::{Table, Value};

/// Most runs of a sweep: more are a mistake in an exponent.
pub const MAX_RUNS: usize = 1_000;
/// Most values of one key.
const MAX_VALUES: usize = 1_000;

/// A sweep file.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
struct Form {
    scene: String,
    #[serde(default)]
    set: Vec<String>,
    #[serde(default)]
    product: Table,
    #[serde(default)]
    zip: Vec<Table>,
}

/// Equal steps from one number to another, both included.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Range {
    from: f64,
    to: f64,
    count: Option<usize>,
    step: Option<f64>,
    #[serde(default)]
    log: bool,
    unit: Option<String>,
}

/// A sweep, worked out.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Sweep {
    /// The scene's path, as the file names it.
    pub scene: String,
    /// The keys that differ between runs.
    pub keys: Vec<String>,
    /// For each run the values of these keys, as TOML writes them.
    pub rows: Vec<Vec<String>>,
    /// `path=value` for every run.
    pub set: Vec<String>,
}

/// What is wrong with a sweep file.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SweepError {
    /// The file does not read.
    #[error("{0}")]
    Form(String),
    /// Values of a key that are none.
    #[error("{key:?}: {why}")]
    Values {
        /// The key concerned.
        key: String,
        /// What is wrong.
        why: String,
    },
    /// Keys that go on together and are not equally long.
    #[error("a [[zip]] has {first} values of {key:?} and {other} of {beside:?}")]
    Uneven {
        /// One key.
        key: String,
        /// Its values.
        first: usize,
        /// Another.
        beside: String,
        /// Its values.
        other: usize,
    },
    /// More runs than a sweep may have, or none.
    #[error("{0} runs; a sweep has 1 to {MAX_RUNS}")]
    Count(usize),
}

/// Whether this text is a sweep and not a scene: it has `[product]` or `[[zip]]`.
#[must_use]
pub fn is_sweep(text: &str) -> bool {
    let table: Option<Table> = text.parse().ok();
    table.is_some_and(|table| table.contains_key("product") || table.contains_key("zip"))
}

impl Sweep {
    /// Works a sweep file out.
    ///
    /// # Errors
    /// The first thing wrong with it.
    pub fn read(text: &str) -> Result<Self, SweepError> {
        let form: Form = toml::from_str(text).map_err(|e| SweepError::Form(e.to_string()))?;
        let mut groups = Vec::new();
        for (key, values) in &form.product {
            groups.push(group(&[(key, values)])?);
        }
        for zip in &form.zip {
            groups.push(group(&zip.iter().collect::<Vec<_>>())?);
        }
        let keys: Vec<String> = groups.iter().flat_map(|(keys, _)| keys.clone()).collect();
        let mut seen = BTreeSet::new();
        if let Some(key) = keys.iter().find(|key| !seen.insert(*key)) {
            let why = "it is there twice".to_owned();
            return Err(SweepError::Values { key: key.clone(), why });
        }
        let count = groups.iter().fold(1usize, |n, (_, rows)| n.saturating_mul(rows.len()));
        if count == 0 || count > MAX_RUNS || groups.is_empty() {
            return Err(SweepError::Count(if groups.is_empty() { 0 } else { count }));
        }
        let mut rows: Vec<Vec<String>> = vec![Vec::new()];
        for (_, values) in &groups {
            let longer = |row: &Vec<String>| {
                let row = row.clone();
                values.iter().map(move |more| [&row[..], &more[..]].concat())
            };
            rows = rows.iter().flat_map(longer).collect();
        }
        Ok(Self { scene: form.scene, keys, rows, set: form.set })
    }

    /// The `path=value` arguments of a run.
    #[must_use]
    pub fn overrides(&self, row: &[String]) -> Vec<String> {
        let own = self.keys.iter().zip(row).map(|(key, value)| format!("{key}={value}"));
        self.set.iter().cloned().chain(own).collect()
    }

    /// What tells a run from the others, for people: its values, each by as much of the end of
    /// its key as no other key has.
    #[must_use]
    pub fn label(&self, row: &[String]) -> String {
        let pair = |(key, value): (&String, &String)| format!("{}={value}", self.name(key));
        self.keys.iter().zip(row).map(pair).collect::<Vec<_>>().join(" ")
    }
}

impl Sweep {
    /// The end of a key, whole parts of it, that no other key ends with.
    fn name<'a>(&self, key: &'a str) -> &'a str {
        let ends = |other: &str, end: &str| {
            let before = other.strip_suffix(end);
            before.is_some_and(|before| before.is_empty() || before.ends_with('.'))
        };
        let own = |end: &&str| !self.keys.iter().any(|other| other != key && ends(other, end));
        let dots = key.rmatch_indices('.').map(|(at, _)| &key[at + 1..]);
        dots.into_iter().find(own).unwrap_or(key)
    }
}

type Group = (Vec<String>, Vec<Vec<String>>);

/// Keys that go on together, and their rows.
fn group(keys: &[(&String, &Value)]) -> Result<Group, SweepError> {
    let mut columns = Vec::new();
    for (key, given) in keys {
        let wrong = |why: String| SweepError::Values { key: (*key).clone(), why };
        columns.push(values(given).map_err(wrong)?);
    }
    let first = columns.first().map_or(0, Vec::len);
    if let Some(at) = columns.iter().position(|column| column.len() != first) {
        let (key, beside) = (keys[0].0.clone(), keys[at].0.clone());
        return Err(SweepError::Uneven { key, first, beside, other: columns[at].len() });
    }
    let row = |n: usize| columns.iter().map(|column| column[n].clone()).collect();
    let names = keys.iter().map(|(key, _)| (*key).clone()).collect();
    Ok((names, (0..first).map(row).collect()))
}

fn values(given: &Value) -> Result<Vec<String>, String> {
    let values = match given {
        Value::Array(list) => list.iter().map(Value::to_string).collect(),
        Value::Table(table) => {
            let range: Range = table.clone().try_into().map_err(|e| plain(&e))?;
            range.values()?
        }
        _ => return Err("it needs a list, or a range with from, to, and count or step".into()),
    };
    match values.len() {
        0 => Err("it has no value".into()),
        n if n > MAX_VALUES => Err(format!("{n} values; the limit is {MAX_VALUES}")),
        _ => Ok(values),
    }
}

fn plain(error: &toml::de::Error) -> String {
    error.message().to_owned()
}

impl Range {
    fn values(&self) -> Result<Vec<String>, String> {
        let Self { from, to, .. } = *self;
        if !from.is_finite() || !to.is_finite() {
            return Err("from and to are finite numbers".into());
        }
        if self.log && (from <= 0.0 || to <= 0.0) {
            return Err("with log, from and to are above 0".into());
        }
        let count = match (self.count, self.step) {
            (Some(count), None) if (2..=MAX_VALUES).contains(&count) => count,
            (Some(count), None) => {
                return Err(format!("count is {count}; it is 2 to {MAX_VALUES}"));
            }
            (None, Some(_)) if self.log => return Err("with log it needs count".into()),
            (None, Some(step)) => {
                let steps = (to - from) / step;
                let whole = (steps.round() - steps).abs() < 1e-9;
                if !steps.is_finite() || steps < 0.0 || !whole || steps >= MAX_VALUES as f64 {
                    return Err(format!("{steps} steps of {step}; it is a whole number, 0 to 999"));
                }
                steps.round() as usize + 1
            }
            _ => return Err("it needs count or step, and not both".into()),
        };
        let share = |k: usize| if count > 1 { k as f64 / (count - 1) as f64 } else { 0.0 };
        let value = |k: usize| match (self.step, self.log) {
            (_, true) => from * libm::pow(to / from, share(k)),
            (Some(step), _) => from + step * k as f64,
            (None, false) => from + (to - from) * share(k),
        };
        Ok((0..count).map(|k| self.text(value(k))).collect())
    }

    /// Nine digits: steps of a tenth are not `0.30000000000000004`.
    fn text(&self, value: f64) -> String {
        let short: f64 = format!("{value:.9e}").parse().unwrap_or(value);
        match &self.unit {
            Some(unit) => format!("{:?}", format!("{short} {unit}")),
            None => format!("{short}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Sweep, SweepError, is_sweep};

    #[test]
    fn products_and_zips_multiply_in_a_fixed_order() {
        let text = r#"
            scene = "../pot"
            set = ["a.b=1"]
            [product]
            "world.seed" = [1, 2]
            "ball.size" = { from = 1, to = 2, count = 3, unit = "mm" }
            [[zip]]
            x = ["p", "q"]
            y = [[1, 2], [3]]
        "#;
        assert!(is_sweep(text) && !is_sweep("[world]\nseed = 1\n"));
        let sweep = Sweep::read(text).expect("a sweep");
        assert_eq!(sweep.scene, "../pot");
        assert_eq!(sweep.rows.len(), 2 * 3 * 2);
        let all: Vec<String> = sweep.rows.iter().map(|row| sweep.label(row)).collect();
        assert_eq!(all[0], r#"size="1 mm" seed=1 x="p" y=[1, 2]"#);
        assert_eq!(all[1], r#"size="1 mm" seed=1 x="q" y=[3]"#);
        assert_eq!(all[11], r#"size="2 mm" seed=2 x="q" y=[3]"#);
        let set = sweep.overrides(&sweep.rows[2]);
        assert_eq!(set, ["a.b=1", "ball.size=\"1 mm\"", "world.seed=2", "x=\"p\"", "y=[1, 2]"]);
    }

    #[test]
    fn a_label_is_as_short_as_it_tells_keys_apart() {
        let label = |keys: &[&str]| {
            let all: String = keys.iter().map(|key| format!("\"{key}\" = [1]\n")).collect();
            let sweep = Sweep::read(&format!("scene = \"s\"\n[product]\n{all}"));
            let sweep = sweep.expect("a sweep");
            sweep.label(&sweep.rows[0])
        };
        assert_eq!(label(&["world.seed"]), "seed=1");
        let two = ["body.bullet.shape.radius", "body.target.shape.radius"];
        assert_eq!(label(&two), "bullet.shape.radius=1 target.shape.radius=1");
        assert_eq!(label(&["a.radius", "b.radius", "c.size"]), "a.radius=1 b.radius=1 size=1");
        // Whole parts: one that only sounds alike is another.
        assert_eq!(label(&["a.radius", "b.subradius"]), "radius=1 subradius=1");
        // One that is the end of another has no shorter name, and needs none.
        assert_eq!(label(&["radius", "a.radius"]), "a.radius=1 radius=1");
    }

    #[test]
    fn ranges_count_step_and_grow() {
        let values = |range: &str| {
            let text = format!("scene = \"s\"\n[product]\nk = {range}\n");
            Sweep::read(&text).map(|sweep| sweep.rows.concat().join(" "))
        };
        let said = |range: &str| values(range).unwrap_or_else(|error| error.to_string());
        assert_eq!(said("{ from = 0, to = 0.3, step = 0.1 }"), "0 0.1 0.2 0.3");
        assert_eq!(said("{ from = 1, to = 100, count = 3, log = true }"), "1 10 100");
        assert_eq!(said("{ from = 2, to = -2, count = 3 }"), "2 0 -2");
        for bad in [
            "{ from = 0, to = 1 }",
            "{ from = 0, to = 1, step = 0.3 }",
            "{ from = 0, to = 1, step = 0.0 }",
            "{ from = 0, to = 1, count = 1 }",
            "{ from = 0, to = 1, count = 5, log = true }",
            "{ from = 0, to = 1, count = 99999 }",
            "{ from = 0, to = 1, count = 3, step = 0.5 }",
            "{ from = 0, to = nan, count = 3 }",
            "{ from = 0, to = 1, cuont = 3 }",
            "[]",
            "7",
        ] {
            assert!(matches!(values(bad), Err(SweepError::Values { .. })), "{bad}");
        }
    }

    #[test]
    fn what_does_not_fit_is_named() {
        let read = |text: &str| Sweep::read(&format!("scene = \"s\"\n{text}"));
        let uneven = read("[[zip]]\na = [1, 2]\nb = [1]\n");
        assert!(matches!(uneven, Err(SweepError::Uneven { first: 2, other: 1, .. })), "{uneven:?}");
        let twice = read("[product]\na = [1]\n[[zip]]\na = [1]\n");
        assert!(matches!(twice, Err(SweepError::Values { .. })), "{twice:?}");
        let many = "[product]\na = { from = 0, to = 1, count = 40 }\n\
                    b = { from = 0, to = 1, count = 40 }\n";
        assert_eq!(read(many), Err(SweepError::Count(1600)));
        assert_eq!(read("[product]\n"), Err(SweepError::Count(0)));
        assert!(matches!(read("product = 3\n"), Err(SweepError::Form(_))));
    }
}
