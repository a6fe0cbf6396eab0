//! What is asked of probes: metrics and what they must come to, whatever the probes watch.

use super::format::{Expected, Metric, Reduction};
use super::paths::{item, path};
use cullet_document::error::suggest;
use cullet_document::tree::{Step, join};
use cullet_scene::context::ResolveContext;
use std::collections::{BTreeMap, BTreeSet};

/// The metrics of a specimen, each with the number of its probe, and what is expected of each.
pub(super) type RequestedMetrics = (Vec<(Metric, usize)>, Vec<Option<Expected>>);

/// Names by which others know the items of a list: each is that of one.
pub(super) fn named_once<'a>(
    shop: &mut ResolveContext<'_>,
    list: &str,
    names: impl Iterator<Item = &'a str>,
) {
    let mut known = BTreeSet::new();
    for (index, name) in names.enumerate() {
        if !known.insert(name) {
            shop.wrong(
                &join(&item(list, index), "name"),
                format!("a second {list} is called {name}"),
            );
        }
    }
}

/// Looks up the names of probes in metrics and of metrics in what is expected.
pub(super) fn read(
    shop: &mut ResolveContext<'_>,
    metrics: &[Metric],
    expects: &BTreeMap<String, Expected>,
    probes: &[&str],
) -> RequestedMetrics {
    named_once(shop, "probe", probes.iter().copied());
    named_once(shop, "metric", metrics.iter().map(|metric| &*metric.name));
    let (mut found, mut expected): RequestedMetrics = (Vec::new(), Vec::new());
    for (index, metric) in metrics.iter().enumerate() {
        let at = item("metric", index);
        numbers(shop, metric, &at);
        let before: Vec<&str> = metrics[..index].iter().map(|m| &*m.name).collect();
        for (key, name) in [("minus", &metric.minus), ("over", &metric.over)] {
            if let Some(name) = name.as_deref().filter(|name| !before.contains(name)) {
                let message = format!("there is no metric \"{name}\" before this one");
                shop.wrong_with(&join(&at, key), message, suggest(name, &before));
            }
        }
        match probes.iter().position(|name| *name == metric.probe) {
            Some(probe) => {
                found.push((metric.clone(), probe));
                expected.push(expects.get(&metric.name).cloned());
            }
            None => {
                let message = format!("there is no probe \"{}\"", metric.probe);
                shop.wrong_with(&join(&at, "probe"), message, suggest(&metric.probe, probes));
            }
        }
    }
    let names: Vec<&str> = metrics.iter().map(|metric| metric.name.as_str()).collect();
    for (name, expected) in expects {
        let at = path(&["expect", name]);
        if !names.contains(&name.as_str()) {
            let message = format!("there is no metric \"{name}\"");
            shop.wrong_with(&at, message, suggest(name, &names));
        }
        bounds(shop, expected, &at);
    }
    (found, expected)
}

/// Holds the keys that a probe has against those that its kind takes; it needs those with a star.
pub(super) fn keys(
    shop: &mut ResolveContext<'_>,
    given: &[(&str, bool)],
    taken: &[&str],
    at: &[Step],
) {
    for &(name, given) in given {
        let known = taken.iter().find(|key| key.trim_end_matches('*') == name);
        if given && known.is_none() {
            let list: Vec<&str> = taken.iter().map(|key| key.trim_end_matches('*')).collect();
            let message = match list.len() {
                0 => format!("this kind of probe takes no `{name}`, nor any other key"),
                _ => format!("this kind of probe takes no `{name}`; it takes {}", list.join(", ")),
            };
            shop.wrong(&join(at, name), message);
        }
        if !given && known.is_some_and(|key| key.ends_with('*')) {
            shop.wrong(at, format!("`{name}` is missing for this kind of probe"));
        }
    }
}

fn bounds(shop: &mut ResolveContext<'_>, expected: &Expected, at: &[Step]) {
    let near = expected.tolerance.is_some() || expected.absolute.is_some();
    let range = expected.min.is_some() || expected.max.is_some();
    if near && expected.value.is_none() {
        shop.wrong(at, "`tolerance` and `absolute` need a `value`");
    }
    if !near && !range {
        shop.wrong(at, "takes `value` and `tolerance` or `absolute`, or `min` or `max`");
    }
    if expected.tolerance.is_some() && expected.value == Some(0.0) {
        shop.wrong(at, "`tolerance` is relative to `value`, which is 0: give `absolute`");
    }
}

/// The numbers that a reduction needs.
fn numbers(shop: &mut ResolveContext<'_>, metric: &Metric, at: &[Step]) {
    let timed = metric.reduce == Reduction::At;
    let bound = matches!(metric.reduce, Reduction::TimeReached | Reduction::TimeAbove);
    let windowed = metric.reduce == Reduction::MaxSlope;
    let needs = [
        ("time", timed, metric.time.is_some()),
        ("threshold", bound, metric.threshold.is_some()),
        ("window", windowed, metric.window.is_some()),
    ];
    for (name, needed, given) in needs {
        if needed && !given {
            shop.wrong(at, format!("`{name}` is missing beside this `reduce`"));
        } else if given && !needed {
            shop.wrong(&join(at, name), format!("this `reduce` takes no `{name}`"));
        }
    }
}
