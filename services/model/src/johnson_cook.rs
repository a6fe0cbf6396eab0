//! The flow and the failure of a metal at any rate and temperature: Johnson and Cook's.

use crate::Hardening;

/// Steps in which a return is found, and the share of the flow stress at which it is \[1\].
const ROUNDS: usize = 60;
const ENOUGH: f64 = 1e-12;

/// Triaxiality below which nothing tears: −⅓ \[Bao and Wierzbicki 2005\].
const CUT_OFF: f64 = -1.0 / 3.0;

/// Least strain at which anything tears: fits with a negative D₁ have none at high triaxialities
/// \[1\].
const LEAST_FAILURE: f64 = 0.01;

/// σ_y = (A + Bεⁿ)(1 + C ln ε̇/ε̇₀)(1 − T*^m) \[Johnson and Cook 1983\], and the strain at which it
/// tears \[1985\].
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub struct JohnsonCook {
    /// A + Bεⁿ: slow and cold.
    pub hardening: Hardening,
    /// C \[1\]; 0 where the rate does not matter.
    pub rate: f64,
    /// ε̇₀, up to which it does not \[1/s\].
    pub reference_rate: f64,
    /// How it softens as it warms up; `None` where that does not matter.
    pub softening: Option<ThermalSoftening>,
    /// At which strain it tears; `None` where it does not.
    pub failure: Option<DuctileFailure>,
}

/// T* = (T − T₀)/(T_m − T₀) takes the share T*^m of the flow stress. The body is at T₀ at first,
/// and warms up where it flows, without passing heat on.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub struct ThermalSoftening {
    /// T_m − T₀ \[K\].
    pub melting: f64,
    /// m \[1\].
    pub exponent: f64,
    /// Heat capacity \[J/(kg K)\].
    pub heat_capacity: f64,
    /// Share of the plastic work that becomes heat \[1\].
    pub heat_share: f64,
}

/// ε_f = (D₁ + D₂ exp(D₃η))(1 + D₄ ln ε̇/ε̇₀)(1 + D₅T*), η being the mean stress over the
/// equivalent one. A point has torn where Σ Δε/ε_f reaches one, and has lost its strength after a
/// further opening that costs G_f.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub struct DuctileFailure {
    /// D₁ to D₅ \[1\].
    pub d: [f64; 5],
}

/// What a point has been through.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FlowHistory {
    /// Equivalent plastic strain ε \[1\].
    pub strain: f64,
    /// T − T₀ \[K\].
    pub warming: f64,
}

impl DuctileFailure {
    /// ε_f at a triaxiality, slow and cold \[1\].
    #[must_use]
    pub fn strain(&self, triaxiality: f64) -> f64 {
        self.d[0] + self.d[1] * libm::exp(self.d[2] * triaxiality)
    }
}

impl From<Hardening> for JohnsonCook {
    fn from(hardening: Hardening) -> Self {
        Self { hardening, rate: 0.0, reference_rate: 1.0, softening: None, failure: None }
    }
}

impl JohnsonCook {
    /// T*, no more than one \[1\].
    fn homologous(&self, warming: f64) -> f64 {
        self.softening.map_or(0.0, |it| (warming / it.melting).clamp(0.0, 1.0))
    }

    /// Whether it flows alike at any rate and temperature, and does not tear.
    #[must_use]
    pub fn is_plain(&self) -> bool {
        self.rate == 0.0 && self.softening.is_none() && self.failure.is_none()
    }

    /// Its numbers: what each is, its value, the least and the greatest that holds.
    #[must_use]
    pub fn bounds(&self) -> Vec<(&'static str, f64, f64, f64)> {
        let mut all = self.hardening.bounds().to_vec();
        all.push(("coefficient of the rate [1]", self.rate, 0.0, 1.0));
        all.push(("reference rate [1/s]", self.reference_rate, 1e-9, 1e9));
        if let Some(heat) = self.softening {
            all.push(("warming until it melts [K]", heat.melting, 1.0, 1e4));
            all.push(("exponent of the softening [1]", heat.exponent, 0.05, 20.0));
            all.push(("heat capacity [J/(kg K)]", heat.heat_capacity, 1.0, 1e6));
            all.push(("share of the work that is heat [1]", heat.heat_share, 0.0, 1.0));
        }
        if let Some(failure) = self.failure {
            let [first, second, slope, rate, heat] = failure.d;
            all.push(("D1 of the failure strain [1]", first, -10.0, 100.0));
            all.push(("D2 of the failure strain [1]", second, 0.0, 100.0));
            all.push(("D3 of the failure strain [1]", slope, -20.0, 20.0));
            all.push(("D4 of the failure strain [1]", rate, -1.0, 10.0));
            all.push(("D5 of the failure strain [1]", heat, -1.0, 100.0));
            let pulled = failure.strain(1.0 / 3.0);
            all.push(("failure strain of a slow pull [1]", pulled, LEAST_FAILURE, 100.0));
        }
        all
    }

    /// What warming leaves of the flow stress \[1\].
    fn left(&self, warming: f64) -> f64 {
        let power = |it: ThermalSoftening| libm::pow(self.homologous(warming), it.exponent);
        1.0 - self.softening.map_or(0.0, power)
    }

    /// ln ε̇/ε̇₀ where that is positive \[1\].
    fn haste(&self, rate: f64) -> f64 {
        if rate > self.reference_rate { libm::log(rate / self.reference_rate) } else { 0.0 }
    }

    /// The stress at which a point flows slowly \[Pa\]: at any rate it is no less.
    #[must_use]
    pub fn slow_stress(&self, history: &FlowHistory) -> f64 {
        self.hardening.stress(history.strain).0 * self.left(history.warming)
    }

    /// The strain by which a point flows in a step of `time` \[s\] in which it would bear `trial`
    /// \[Pa\], and lets go of `stiffness` \[Pa\] of that a strain: 3μ. Zero where it bears it.
    #[must_use]
    pub fn flow(&self, trial: f64, stiffness: f64, history: &FlowHistory, time: f64) -> f64 {
        let left = self.left(history.warming);
        let flow_stress = |more: f64| {
            let (slow, slope) = self.hardening.stress(history.strain + more);
            let haste = 1.0 + self.rate * self.haste(more / time);
            let quicker = if haste > 1.0 { self.rate * slow / more } else { 0.0 };
            (left * slow * haste, left * (slope * haste + quicker))
        };
        if trial <= flow_stress(0.0).0 {
            return 0.0;
        }
        let (mut low, mut high, mut more) = (0.0, trial / stiffness, 0.0);
        for _ in 0..ROUNDS {
            let (stress, slope) = flow_stress(more);
            let over = trial - stiffness * more - stress;
            if over.abs() <= ENOUGH * trial {
                break;
            }
            *(if over > 0.0 { &mut low } else { &mut high }) = more;
            let next = more + over / (stiffness + slope);
            more = if next > low && next < high { next } else { 0.5 * (low + high) };
        }
        more
    }

    /// By how much a point of that `density` \[kg/m³\] warms up from plastic work \[J/m³\] \[K\].
    #[must_use]
    pub fn warming(&self, work: f64, density: f64) -> f64 {
        let heat = |it: ThermalSoftening| it.heat_share * work / (density * it.heat_capacity);
        self.softening.map_or(0.0, heat)
    }

    /// Share of what it can flow until it tears that `strain` took, flown at a `rate` \[1/s\] and a
    /// triaxiality \[1\].
    #[must_use]
    pub fn spent(&self, strain: f64, rate: f64, triaxiality: f64, warming: f64) -> f64 {
        let Some(failure) = self.failure else { return 0.0 };
        if triaxiality <= CUT_OFF {
            return 0.0;
        }
        let (first, d) = (failure.strain(triaxiality), failure.d);
        let most =
            first * (1.0 + d[3] * self.haste(rate)) * (1.0 + d[4] * self.homologous(warming));
        strain / most.max(LEAST_FAILURE)
    }
}

#[cfg(test)]
mod tests {
    use super::{DuctileFailure, FlowHistory, JohnsonCook, ThermalSoftening};
    use crate::Hardening;

    /// Steel 4340 \[Johnson and Cook 1985\].
    const STEEL: JohnsonCook = JohnsonCook {
        hardening: Hardening { yield_stress: 792e6, hardening: 510e6, exponent: 0.26 },
        rate: 0.014,
        reference_rate: 1.0,
        softening: Some(ThermalSoftening {
            melting: 1500.0,
            exponent: 1.03,
            heat_capacity: 477.0,
            heat_share: 0.9,
        }),
        failure: Some(DuctileFailure { d: [0.05, 3.44, -2.12, 0.002, 0.61] }),
    };

    #[test]
    fn what_flows_ends_at_the_stress_of_its_rate_and_temperature() {
        let (stiffness, time) = (3.0 * 77e9, 1e-7);
        for (trial, strain, warming) in [(1.5e9, 0.0, 0.0), (5e9, 0.2, 300.0), (3e10, 1.0, 1400.0)]
        {
            let history = FlowHistory { strain, warming };
            let more = STEEL.flow(trial, stiffness, &history, time);
            let borne = trial - stiffness * more;
            let slow = 792e6 + 510e6 * libm::pow(strain + more, 0.26);
            let wanted = slow
                * (1.0 + 0.014 * libm::log(more / time))
                * (1.0 - libm::pow(warming / 1500.0, 1.03));
            assert!((borne / wanted - 1.0).abs() < 1e-9, "{trial}: {borne}, not {wanted}");
        }
        let melted = FlowHistory { strain: 0.0, warming: 2000.0 };
        let more = STEEL.flow(1e9, stiffness, &melted, time);
        assert!((more * stiffness / 1e9 - 1.0).abs() < 1e-9, "melted, it bears nothing");
        assert_eq!(STEEL.flow(700e6, stiffness, &FlowHistory::default(), time), 0.0);
    }

    /// 4340 tears at 0.05 + 3.44 e^(−2.12/3) in slow tension, later in shear, and not when pressed.
    #[test]
    fn tension_tears_sooner_than_shear() {
        let strain = |triaxiality| 1.0 / STEEL.spent(1.0, 1e-3, triaxiality, 0.0);
        assert!((strain(1.0 / 3.0) / 1.747 - 1.0).abs() < 1e-3, "{}", strain(1.0 / 3.0));
        assert!((strain(0.0) / 3.49 - 1.0).abs() < 1e-9 && strain(1.0) < 0.5);
        assert_eq!(STEEL.spent(1.0, 1.0, -0.4, 0.0), 0.0);
    }
}
