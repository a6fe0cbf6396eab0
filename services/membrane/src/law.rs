//! What one bond bears and remembers.
//!
//! All laws are one law in a generalised stretch g: the energy of a bond is ½k g². With s the
//! length over that at rest and ε* the strain that a quantity which diffuses gives it,
//! s* = s/(1 + ε*): paper and foil have g = s* − 1, rubber has g = ½(s* − 1/s*). That is Han and
//! others' rubber 2c(s − s⁻³) with k = 8c. A bond of each law costs ½k s_c² until it breaks.

use cullet_model::MembraneLaw;

/// s_y of a foil is lowered to this share of s_c where it would be more than s_c/√3: above that no
/// work is left for flow.
const FOIL_CAP: f64 = 1.0 / 1.8;
/// Bonds begin to soften at this share of s_c at the latest: sudden breaking traps cracks.
const SOFTENING: f64 = 0.5;

/// At which stretches a bond yields and breaks \[1\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StretchLimits {
    /// s₀ of a brittle bond or rubber, s_y of a foil.
    pub first: f64,
    /// s_c.
    pub critical: f64,
}

/// What is left of the numbers of a bond \[1\]: of E, G and the strength.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LeftShares {
    /// q_E.
    pub stiffness: f64,
    /// q_G.
    pub toughness: f64,
    /// q_σ.
    pub strength: f64,
}

impl LeftShares {
    /// Of a bond that nothing has changed.
    pub const WHOLE: Self = Self { stiffness: 1.0, toughness: 1.0, strength: 1.0 };
}

impl StretchLimits {
    /// Limits of a bond of the stretch `strength` = σ/E and of s_c, `critical`.
    #[must_use]
    pub fn new(law: MembraneLaw, strength: f64, critical: f64, left: LeftShares) -> Self {
        let critical = critical * (left.toughness / left.stiffness).sqrt();
        let strength = strength * left.strength / left.stiffness;
        let first = match law {
            MembraneLaw::Foil if strength >= critical / 3.0_f64.sqrt() => FOIL_CAP * critical,
            MembraneLaw::Foil => strength,
            MembraneLaw::Brittle | MembraneLaw::Rubber => strength.min(SOFTENING * critical),
        };
        Self { first, critical }
    }
}

/// What a bond remembers: nothing of it ever heals.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BondMemory {
    /// p: plastic stretch, of a foil \[1\].
    pub plastic: f64,
    /// α_p: what it has flowed in tension \[1\].
    pub flowed: f64,
    /// d: 1 once it is broken \[1\].
    pub damage: f64,
}

/// What a bond does as it is stretched, by its stiffness k.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BondTension {
    /// T/k: derivative of the energy ½g² by g \[1\].
    pub tension: f64,
    /// Work of damage over k \[1\].
    pub broken: f64,
    /// Plastic work over k \[1\].
    pub plastic: f64,
}

/// g of a stretch s* \[1\].
#[inline(always)]
#[must_use]
pub fn generalised(law: MembraneLaw, stretch: f64) -> f64 {
    match law {
        MembraneLaw::Rubber => 0.5 * (stretch - 1.0 / stretch),
        MembraneLaw::Brittle | MembraneLaw::Foil => stretch - 1.0,
    }
}

/// Its derivative by s* \[1\].
#[inline(always)]
#[must_use]
pub fn generalised_slope(law: MembraneLaw, stretch: f64) -> f64 {
    match law {
        MembraneLaw::Rubber => 0.5 * (1.0 + 1.0 / (stretch * stretch)),
        MembraneLaw::Brittle | MembraneLaw::Foil => 1.0,
    }
}

/// Stretches a bond to g; `fails` says whether it may break.
#[inline(always)]
pub fn stretched(
    law: MembraneLaw,
    g: f64,
    memory: &mut BondMemory,
    limits: StretchLimits,
    fails: bool,
) -> BondTension {
    match law {
        MembraneLaw::Foil => flowed(g, memory, limits, fails),
        MembraneLaw::Brittle | MembraneLaw::Rubber => softened(g, memory, limits, fails),
    }
}

/// Stretch that a bond's dilatation counts, by its memory: what is not broken and has not flowed.
#[inline(always)]
#[must_use]
pub fn counted(g: f64, memory: BondMemory) -> f64 {
    match memory.damage >= 1.0 {
        true => 0.0,
        false => (1.0 - memory.damage) * (g - memory.plastic),
    }
}

/// The least and the greatest g at which a bond's memory stays as it is; a broken one has no
/// bounds.
#[must_use]
pub fn untouched(
    law: MembraneLaw,
    memory: BondMemory,
    limits: StretchLimits,
    fails: bool,
) -> [f64; 2] {
    let none = [f64::NEG_INFINITY, f64::INFINITY];
    let first = limits.first;
    match law {
        _ if memory.damage >= 1.0 => none,
        MembraneLaw::Foil => {
            let even = limits.critical * limits.critical / (3.0 * first);
            let share = if fails { (2.0 - memory.flowed / even).clamp(0.0, 1.0) } else { 1.0 };
            [memory.plastic - first * share, memory.plastic + first * share]
        }
        MembraneLaw::Brittle | MembraneLaw::Rubber if fails => {
            let last = limits.critical * limits.critical / first;
            let least = first * last / (first + (1.0 - memory.damage) * (last - first));
            [f64::NEG_INFINITY, least]
        }
        MembraneLaw::Brittle | MembraneLaw::Rubber => none,
    }
}

/// Linear softening from s₀ to s_f = s_c²/s₀.
#[inline(always)]
fn softened(g: f64, memory: &mut BondMemory, limits: StretchLimits, fails: bool) -> BondTension {
    let mut broken = 0.0;
    if g > limits.first && fails {
        let last = limits.critical * limits.critical / limits.first;
        let damage = 1.0 - limits.first / g * (last - g) / (last - limits.first);
        let damage = damage.min(1.0);
        if damage > memory.damage {
            broken = 0.5 * g * g * (damage - memory.damage);
            memory.damage = damage;
        }
    }
    let left = if g > 0.0 { 1.0 - memory.damage } else { 1.0 };
    let left = if memory.damage >= 1.0 { 0.0 } else { left };
    BondTension { tension: left * g, broken, plastic: 0.0 }
}

/// Flow at s_y up to α_u = s_c²/(3s_y), then at ever less up to 2α_u.
#[inline(always)]
fn flowed(g: f64, memory: &mut BondMemory, limits: StretchLimits, fails: bool) -> BondTension {
    if memory.damage >= 1.0 {
        return BondTension::default();
    }
    let even = limits.critical * limits.critical / (3.0 * limits.first);
    let yields = |flowed: f64| match fails {
        true => limits.first * (2.0 - flowed / even).clamp(0.0, 1.0),
        false => limits.first,
    };
    let trial = g - memory.plastic;
    let limit = yields(memory.flowed);
    if trial.abs() <= limit {
        return BondTension { tension: trial, broken: 0.0, plastic: 0.0 };
    }
    let flow = match trial > 0.0 {
        false => -(-trial - limit),
        true => tensile_flow(trial, memory.flowed, limits.first, even, fails),
    };
    memory.plastic += flow;
    memory.flowed += flow.max(0.0);
    let left = g - memory.plastic;
    if fails && memory.flowed >= 2.0 * even {
        memory.damage = 1.0;
        return BondTension {
            tension: 0.0,
            broken: 0.5 * left * left,
            plastic: flow * (left + 0.5 * flow),
        };
    }
    BondTension { tension: left, broken: 0.0, plastic: flow * (left + 0.5 * flow) }
}

/// Flow after which the stretch that is left is where the bond yields.
#[inline(always)]
fn tensile_flow(trial: f64, flowed: f64, first: f64, even: f64, fails: bool) -> f64 {
    let flat = trial - first;
    if !fails || flowed + flat <= even {
        return flat;
    }
    // trial − f = first·(2 − (flowed + f)/even), or all of it where that is negative.
    let slope = first / even;
    let flow = (trial - 2.0 * first + slope * flowed) / (1.0 - slope);
    if slope < 1.0 && flowed + flow < 2.0 * even { flow } else { trial }
}

#[cfg(test)]
mod tests {
    use super::{
        BondMemory, LeftShares, StretchLimits, generalised, generalised_slope, stretched, untouched,
    };
    use cullet_model::MembraneLaw;

    const CRITICAL: f64 = 0.02;
    const STRENGTH: f64 = 0.004;

    fn limits(law: MembraneLaw) -> StretchLimits {
        StretchLimits::new(law, STRENGTH, CRITICAL, LeftShares::WHOLE)
    }

    /// T8: work of a bond that is stretched from `from` to `to` in steps, and what it lost.
    fn pull(law: MembraneLaw, from: f64, to: f64, memory: &mut BondMemory) -> [f64; 2] {
        let steps = 200_000;
        let (mut work, mut lost) = (0.0, 0.0);
        let mut last = stretched(law, from, memory, limits(law), true).tension;
        for k in 1..=steps {
            let g = from + (to - from) * f64::from(k) / f64::from(steps);
            let did = stretched(law, g, memory, limits(law), true);
            work += 0.5 * (last + did.tension) * (to - from) / f64::from(steps);
            lost += did.broken + did.plastic;
            last = did.tension;
        }
        [work, lost]
    }

    #[test]
    fn a_bond_of_each_law_costs_what_it_should() {
        let target = 0.5 * CRITICAL * CRITICAL;
        for law in [MembraneLaw::Brittle, MembraneLaw::Rubber, MembraneLaw::Foil] {
            let mut memory = BondMemory::default();
            let [work, lost] = pull(law, 0.0, 0.2, &mut memory);
            assert_eq!(memory.damage, 1.0, "{law:?}");
            assert!((work / target - 1.0).abs() < 1e-6, "{law:?}: {}", work / target);
            // Steps of damage count the stretch at their end.
            assert!((lost - work).abs() < 3e-4 * target, "{law:?}: {}", lost / work);
            let after = stretched(law, -0.1, &mut memory, limits(law), true);
            assert_eq!(after.tension, 0.0);
        }
    }

    /// The corners of the polygon that tension follows give the area to rounding.
    #[test]
    fn the_area_under_a_law_is_exact() {
        let target = 0.5 * CRITICAL * CRITICAL;
        let brittle = limits(MembraneLaw::Brittle);
        let last = brittle.critical * brittle.critical / brittle.first;
        assert!((0.5 * brittle.first * last / target - 1.0).abs() < 1e-10);
        for share in [0.1, 0.5, 0.9] {
            let g = brittle.first + share * (last - brittle.first);
            let mut memory = BondMemory::default();
            let did = stretched(MembraneLaw::Brittle, g, &mut memory, brittle, true);
            assert!((did.tension - (1.0 - share) * brittle.first).abs() < 1e-12 * brittle.first);
        }
        let foil = limits(MembraneLaw::Foil);
        let even = foil.critical * foil.critical / (3.0 * foil.first);
        let mut memory = BondMemory::default();
        let mut cost = 0.0;
        // Up to α_u, then half way down, then to the end; each of these is one step of the law.
        for (g, tension) in [
            (foil.first + even, foil.first),
            (0.5 * foil.first + 1.5 * even, 0.5 * foil.first),
            (2.0 * even, 0.0),
        ] {
            let before = memory.flowed;
            let did = stretched(MembraneLaw::Foil, g, &mut memory, foil, true);
            assert!((did.tension - tension).abs() < 1e-12, "{g}: {}", did.tension);
            let yields = |flowed: f64| foil.first * (2.0 - flowed / even).clamp(0.0, 1.0);
            cost += 0.5 * (yields(before) + yields(memory.flowed)) * (memory.flowed - before);
        }
        assert!((cost / target - 1.0).abs() < 1e-10, "{}", cost / target);
        assert_eq!(memory.damage, 1.0);
    }

    #[test]
    fn nothing_heals() {
        let law = MembraneLaw::Brittle;
        let mut memory = BondMemory::default();
        pull(law, 0.0, 0.03, &mut memory);
        let damage = memory.damage;
        assert!(damage > 0.1 && damage < 1.0, "{damage}");
        let [_, lost] = pull(law, 0.03, 0.0, &mut memory);
        assert_eq!((lost, memory.damage), (0.0, damage));
        let [_, lost] = pull(law, 0.0, 0.03, &mut memory);
        assert!(lost <= 1e-15 && memory.damage == damage, "{lost}");
        // In compression it is whole.
        let did = stretched(law, -0.01, &mut memory, limits(law), true);
        assert_eq!(did.tension, -0.01);
    }

    /// Within the bounds that are said nothing is remembered, and just beyond them something is.
    #[test]
    fn bounds_say_where_memory_stays() {
        for law in [MembraneLaw::Brittle, MembraneLaw::Rubber, MembraneLaw::Foil] {
            for most in [0.0, 0.003, 0.012, 0.03] {
                let mut memory = BondMemory::default();
                pull(law, 0.0, most, &mut memory);
                let changes = |g: f64, fails: bool| {
                    let mut after = memory;
                    stretched(law, g, &mut after, limits(law), fails);
                    after != memory
                };
                let [low, high] = untouched(law, memory, limits(law), true);
                assert!(
                    !changes(high - 1e-9, true) && changes(high + 1e-9, true),
                    "{law:?} {most}"
                );
                let lowest = if low.is_finite() { low } else { -0.5 };
                assert!(!changes(lowest + 1e-9, true), "{law:?} {most}");
                assert_eq!(changes(low.max(-0.5) - 1e-9, true), law == MembraneLaw::Foil);
                let [low, high] = untouched(law, memory, limits(law), false);
                assert!(!changes(high.min(0.5) - 1e-9, false), "{law:?} {most}");
                assert!(!changes(low.max(-0.5) + 1e-9, false), "{law:?} {most}");
            }
        }
        let broken = BondMemory { damage: 1.0, ..BondMemory::default() };
        let none = untouched(MembraneLaw::Foil, broken, limits(MembraneLaw::Foil), true);
        assert_eq!(none, [f64::NEG_INFINITY, f64::INFINITY]);
    }

    #[test]
    fn a_foil_sets() {
        let law = MembraneLaw::Foil;
        let mut memory = BondMemory::default();
        pull(law, 0.0, 3.0 * STRENGTH, &mut memory);
        let did = stretched(law, 2.0 * STRENGTH, &mut memory, limits(law), true);
        assert!(did.tension.abs() < 1e-15, "{}", did.tension);
        assert!((memory.plastic / (2.0 * STRENGTH) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn rubber_is_the_papers_law() {
        for s in [0.7, 1.0, 1.4, 2.0] {
            let law = MembraneLaw::Rubber;
            let tension = generalised(law, s) * generalised_slope(law, s);
            // 2c(s − s⁻³) with c = 1/8 of k.
            assert!((tension - 0.25 * (s - 1.0 / (s * s * s))).abs() < 1e-15);
        }
    }
}
