//! What a scene must show, held against what a run showed.

use super::format::{Bounds, Expect, ShareBounds};
use cullet_document::check::tell;
use std::collections::BTreeMap;

/// What a run showed, as far as expectations ask.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Observed {
    /// Bodies that broke.
    pub fractures: u64,
    /// Fragments made.
    pub fragments: u64,
    /// Bodies at the end.
    pub bodies_final: u64,
    /// Jobs that failed.
    pub failed: u64,
    /// Fragments whose surface is not closed.
    pub open_fragments: u64,
    /// Parts that sheets have come to.
    pub sheet_pieces: u64,
    /// Joints that broke, those of glue counted.
    pub joints_broken: u64,
    /// Largest relative error of mass \[1\].
    pub mass_rel_error: f64,
    /// Largest relative error of momentum \[1\].
    pub momentum_rel_error: f64,
    /// Largest relative growth of kinetic energy \[1\].
    pub energy_gain_rel: f64,
    /// Share of the fragments at the end that was sampled, by number and by mass \[1\]; nothing
    /// where it is not known.
    pub sampled: Option<(f64, f64)>,
    /// Fragments of each body of the scene that broke, by its name.
    pub broken: BTreeMap<String, u64>,
}

impl Observed {
    /// The bodies that broke and are `name`, or were made by the generator `name`.
    fn broken_of<'a>(&'a self, name: &'a str) -> impl Iterator<Item = (&'a str, u64)> {
        let made_by = move |body: &str| {
            body.strip_prefix(name).is_some_and(|rest| {
                rest.is_empty()
                    || rest.strip_prefix('-').is_some_and(|tail| {
                        tail.split('-').all(|part| {
                            !part.is_empty() && part.bytes().all(|byte| byte.is_ascii_digit())
                        })
                    })
            })
        };
        self.broken
            .iter()
            .filter(move |(body, _)| made_by(body))
            .map(|(body, count)| (body.as_str(), *count))
    }
}

impl Expect {
    /// What does not hold, a sentence each; nothing when the scene showed what it must.
    #[must_use]
    pub fn check(&self, seen: &Observed) -> Vec<String> {
        let mut broken = Vec::new();
        let counts = [
            ("fractures", self.fractures, seen.fractures),
            ("fragments", self.fragments, seen.fragments),
            ("bodies_final", self.bodies_final, seen.bodies_final),
            ("failed", self.failed, seen.failed),
            ("open_fragments", self.open_fragments, seen.open_fragments),
            ("sheet_pieces", self.sheet_pieces, seen.sheet_pieces),
            ("joints_broken", self.joints_broken, seen.joints_broken),
        ];
        for (name, bounds, value) in counts {
            broken.extend(bounds.and_then(|bounds| outside(name, bounds, value)));
        }
        let errors = [
            ("mass_rel_error", self.mass_rel_error, seen.mass_rel_error),
            ("momentum_rel_error", self.momentum_rel_error, seen.momentum_rel_error),
            ("energy_gain_rel", self.energy_gain_rel, seen.energy_gain_rel),
        ];
        for (name, most, value) in errors {
            if let Some(most) = most.filter(|most| value.is_nan() || value > *most) {
                let (most, value) = (tell(most), tell(value));
                broken.push(format!("{name} must be at most {most}; it was {value}"));
            }
        }
        let shares = [("sampled", self.sampled, 0), ("sampled_mass", self.sampled_mass, 1)];
        for (name, bounds, which) in shares {
            let value = seen.sampled.map(|(pieces, mass)| [pieces, mass][which]);
            broken.extend(bounds.and_then(|bounds| beyond(name, bounds, value)));
        }
        for name in &self.broken {
            if seen.broken_of(name).next().is_none() {
                broken.push(format!("{name} must break; it stayed whole"));
            }
        }
        for name in &self.unbroken {
            if let Some((body, _)) = seen.broken_of(name).next() {
                broken.push(format!("{name} must stay whole; {body} broke"));
            }
        }
        for (name, least) in &self.min_fragments_of {
            let count: u64 = seen.broken_of(name).map(|(_, count)| count).sum();
            if count < *least {
                let message =
                    format!("{name} must give at least {least} fragments; it gave {count}");
                broken.push(message);
            }
        }
        broken
    }
}

fn outside(name: &str, bounds: Bounds, value: u64) -> Option<String> {
    if let Some(least) = bounds.min.filter(|least| value < *least) {
        return Some(format!("{name} must be at least {least}; it was {value}"));
    }
    if let Some(most) = bounds.max.filter(|most| value > *most) {
        return Some(format!("{name} must be at most {most}; it was {value}"));
    }
    None
}

fn beyond(name: &str, bounds: ShareBounds, value: Option<f64>) -> Option<String> {
    let Some(value) = value else {
        return Some(format!("{name} is not known: a worker of an older build did not tell"));
    };
    let told = |bound: f64, word: &str| {
        let (bound, value) = (tell(bound), tell(value));
        format!("{name} must be at {word} {bound}; it was {value}")
    };
    let least = bounds.min.filter(|least| value < *least).map(|least| told(least, "least"));
    least.or(bounds.max.filter(|most| value > *most).map(|most| told(most, "most")))
}

#[cfg(test)]
mod tests {
    use super::{Bounds, Expect, Observed, ShareBounds};

    #[test]
    fn a_share_that_was_sampled_is_held_to_its_bounds() {
        let most = |max| Some(ShareBounds { min: None, max: Some(max) });
        let expect = Expect { sampled: most(0.2), sampled_mass: most(0.5), ..Expect::default() };
        let at = |sampled| expect.check(&Observed { sampled, ..Observed::default() });
        assert_eq!(at(Some((0.2, 0.5))), Vec::<String>::new());
        assert_eq!(at(Some((0.25, 0.1))), ["sampled must be at most 0.2; it was 0.25"]);
        assert_eq!(at(Some((0.0, 0.75))), ["sampled_mass must be at most 0.5; it was 0.75"]);
        assert_eq!(at(None).len(), 2, "what is not known does not hold");
    }

    fn seen() -> Observed {
        Observed {
            fractures: 2,
            fragments: 30,
            broken: [("pot".to_owned(), 20), ("wall-0-3-1".to_owned(), 10)].into(),
            ..Observed::default()
        }
    }

    #[test]
    fn what_was_shown_is_accepted() {
        let expect = Expect {
            fractures: Some(Bounds { min: Some(2), max: Some(2) }),
            broken: vec!["pot".to_owned(), "wall".to_owned()],
            unbroken: vec!["wall-0-3".to_owned(), "floor".to_owned()],
            min_fragments_of: [("wall".to_owned(), 10)].into(),
            mass_rel_error: Some(1e-9),
            ..Expect::default()
        };
        // wall-0-3 names one body; wall-0-3-1 would be made by a generator of that name.
        let report = expect.check(&seen());
        assert_eq!(report, ["wall-0-3 must stay whole; wall-0-3-1 broke"]);
    }

    #[test]
    fn each_broken_expectation_is_a_sentence() {
        let expect = Expect {
            fragments: Some(Bounds { min: Some(31), max: None }),
            open_fragments: Some(Bounds { min: None, max: Some(0) }),
            sheet_pieces: Some(Bounds { min: Some(2), max: None }),
            broken: vec!["ball".to_owned()],
            unbroken: vec!["pot".to_owned()],
            min_fragments_of: [("pot".to_owned(), 21)].into(),
            mass_rel_error: Some(1e-9),
            energy_gain_rel: Some(0.0),
            ..Expect::default()
        };
        let seen = Observed {
            open_fragments: 1,
            mass_rel_error: f64::NAN,
            energy_gain_rel: 1e-3,
            ..seen()
        };
        assert_eq!(
            expect.check(&seen),
            [
                "fragments must be at least 31; it was 30",
                "open_fragments must be at most 0; it was 1",
                "sheet_pieces must be at least 2; it was 0",
                "mass_rel_error must be at most 1e-9; it was NaN",
                "energy_gain_rel must be at most 0; it was 0.001",
                "ball must break; it stayed whole",
                "pot must stay whole; pot broke",
                "pot must give at least 21 fragments; it gave 20",
            ]
        );
    }
}
