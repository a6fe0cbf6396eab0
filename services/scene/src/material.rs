//! Materials: what a preset is, and what a scene makes of it.

mod ductile;
mod preset;
mod presets;

use super::direction::direction;
use super::format::{
    self, DEFAULT_FRICTION, DEFAULT_RESTITUTION, DEFAULT_WEIBULL, Layers, WeakPlane,
};
use super::sourced::Fault;
use super::treatment;
use cullet_document::check::tell;
use cullet_model::surface::{CRACK_FRICTION, HARDNESS_OVER_STRENGTH};
use cullet_model::{
    BondedSolid, DuctileFailure, Hardening, JohnsonCook, Material, SurfaceLaw, ThermalSoftening,
    Treatment,
};
pub use preset::{Preset, PresetFlow, PresetPlasticity};
use presets::PRESETS;

pub use super::sourced::{Kind, Sourced};

/// The presets, by name.
#[must_use]
pub fn presets() -> &'static [Preset] {
    PRESETS
}

/// The preset of that name.
#[must_use]
pub fn preset(name: &str) -> Option<&'static Preset> {
    PRESETS.iter().find(|preset| preset.name == name)
}

/// Whether there is a preset of that name.
#[must_use]
pub fn is_preset(name: &str) -> bool {
    preset(name).is_some()
}

/// The presets as a table for people.
#[must_use]
pub fn presets_text() -> String {
    let mut text = String::from(
        "name                    density    E      ν     strength   G_f    weibull restitution \
         friction  hardness  breaks\n\
         \x20                       [kg/m³]   [GPa]  [1]     [MPa]   [J/m²]    [1]       [1]       \
         [1]      [MPa]\n",
    );
    let mark = |value: &Sourced| {
        if value.kind == Kind::Measured { ' ' } else { '~' }
    };
    for p in PRESETS {
        text.push_str(&format!(
            "{:23} {:>6}{} {:>7}{} {:>5}{} {:>7}{} {:>7}{} {:>5}{} {:>9}{} {:>9}{} {:>8}{}   {}\n",
            p.name,
            tell(p.density.value),
            mark(&p.density),
            tell(p.young.value / 1e9),
            mark(&p.young),
            tell(p.poisson.value),
            mark(&p.poisson),
            tell(p.strength.value / 1e6),
            mark(&p.strength),
            tell(p.fracture_energy.value),
            mark(&p.fracture_energy),
            tell(p.weibull.value),
            mark(&p.weibull),
            tell(p.restitution.value),
            mark(&p.restitution),
            tell(p.friction.value),
            mark(&p.friction),
            tell(p.hardness.value / 1e6),
            mark(&p.hardness),
            if p.breakable { "yes" } else { "no" },
        ));
    }
    text.push_str(
        "~ is typical; the others are measured. --json names the source of each value.\n",
    );
    text
}

/// The presets with all sources, as JSON.
#[must_use]
pub fn presets_json() -> serde_json::Value {
    serde_json::to_value(PRESETS).unwrap_or_default()
}

/// A material as bodies use it.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneMaterial {
    /// What the scene calls it.
    pub name: String,
    /// Mass density ρ \[kg/m³\].
    pub density: f64,
    /// Young's modulus E \[Pa\].
    pub young: f64,
    /// Poisson's ratio ν \[1\].
    pub poisson: f64,
    /// Tensile strength σ_f \[Pa\].
    pub strength: f64,
    /// Mode I fracture energy G_f \[J/m²\].
    pub fracture_energy: f64,
    /// Weibull modulus m of the flaws \[1\].
    pub weibull: f64,
    /// Correlation length of the flaws \[m\]; four spacings of the solve without it.
    pub correlation: Option<f64>,
    /// A weak plane, in the body's own frame.
    pub weak_plane: Option<WeakPlane>,
    /// Layers, in the body's own frame.
    pub layers: Option<Layers>,
    /// Speed after over speed before a bounce \[1\].
    pub restitution: f64,
    /// Coulomb friction \[1\].
    pub friction: f64,
    /// How its surface bears others, and its cracks their sides.
    pub surface: SurfaceLaw,
    /// Whether bodies of it break unless they say otherwise.
    pub breakable: bool,
    /// What was done to it, if it is glass.
    pub treatment: Option<Treatment>,
    /// How it yields, if it is a metal that dents.
    pub plasticity: Option<JohnsonCook>,
    /// Its bonds where it is solved by `peridynamics`; they yield as `plasticity` says.
    pub bonds: BondedSolid,
}

impl From<PresetPlasticity> for JohnsonCook {
    fn from(preset: PresetPlasticity) -> Self {
        let PresetPlasticity { yield_stress, hardening, exponent, flow } = preset;
        let [yield_stress, hardening, exponent] =
            [yield_stress, hardening, exponent].map(|number| number.value);
        let plain = Self::from(Hardening { yield_stress, hardening, exponent });
        let Some(flow) = flow else { return plain };
        Self {
            rate: flow.rate.value,
            softening: Some(ThermalSoftening {
                melting: flow.melting.value,
                exponent: flow.softening.value,
                heat_capacity: flow.heat_capacity.value,
                heat_share: HEAT_SHARE,
            }),
            failure: Some(DuctileFailure { d: flow.failure.map(|number| number.value) }),
            ..plain
        }
    }
}

impl From<format::Plasticity> for JohnsonCook {
    fn from(written: format::Plasticity) -> Self {
        let hardening = Hardening {
            yield_stress: written.yield_stress,
            hardening: written.hardening.unwrap_or(0.0),
            exponent: written.exponent.unwrap_or(1.0),
        };
        let plain = Self::from(hardening);
        let softening = written.softening.map(|heat| ThermalSoftening {
            melting: heat.melting,
            exponent: heat.exponent,
            heat_capacity: heat.heat_capacity,
            heat_share: heat.heat_share.unwrap_or(HEAT_SHARE),
        });
        Self {
            rate: written.rate.unwrap_or(0.0),
            reference_rate: written.reference_rate.unwrap_or(plain.reference_rate),
            softening,
            failure: written.failure.map(|d| DuctileFailure { d }),
            ..plain
        }
    }
}

impl From<&Preset> for SceneMaterial {
    fn from(preset: &Preset) -> Self {
        Self {
            name: preset.name.to_owned(),
            density: preset.density.value,
            young: preset.young.value,
            poisson: preset.poisson.value,
            strength: preset.strength.value,
            fracture_energy: preset.fracture_energy.value,
            weibull: preset.weibull.value,
            correlation: None,
            weak_plane: None,
            layers: None,
            restitution: preset.restitution.value,
            friction: preset.friction.value,
            surface: SurfaceLaw { hardness: preset.hardness.value, friction: CRACK_FRICTION },
            breakable: preset.breakable,
            treatment: preset.treatment.map(Treatment::from),
            plasticity: preset.plasticity.map(JohnsonCook::from),
            bonds: BondedSolid::default(),
        }
    }
}

/// Plastic strain that an indenter makes \[1\].
const TABOR_STRAIN: f64 = 0.08;

/// Share of the plastic work that becomes heat, unless a scene says otherwise \[1\].
const HEAT_SHARE: f64 = 0.9;

/// Bounds of σ_f/E \[1\]: outside, a unit was mistaken or the solid is not brittle (F77).
pub(super) const STRENGTH_OVER_YOUNG: (f64, f64) = (1e-5, 1e-1);

/// Young's modulus below which a toughness is not judged \[Pa\].
const SOFT: f64 = 1e8;

/// Greatest strength over Young's modulus of bodies that move as they deform: rubber has 10 \[1\].
const MOST_STRETCHY: f64 = 20.0;

/// Usual bounds of K_Ic = √(E·G_f) \[Pa·√m\] (F77).
pub(super) const TOUGHNESS: (f64, f64) = (0.05e6, 200e6);

/// Fastest usual pressure wave \[m/s\] (F77).
pub(super) const WAVE_SPEED: f64 = 12_000.0;

impl SceneMaterial {
    /// A written material on its preset; the keys that neither gives are the error.
    pub(super) fn from_written(
        written: &format::Material,
        base: Option<&Preset>,
    ) -> Result<Self, Vec<&'static str>> {
        let base = base.map(Self::from);
        let mut missing = Vec::new();
        let mut take = |key, own: Option<f64>, preset: Option<f64>| match own.or(preset) {
            Some(value) => value,
            None => {
                missing.push(key);
                0.0
            }
        };
        let of = |get: fn(&Self) -> f64| base.as_ref().map(get);
        let mut material = Self {
            name: written.name.clone(),
            density: take("density", written.density, of(|m| m.density)),
            young: take("young", written.young, of(|m| m.young)),
            poisson: take("poisson", written.poisson, of(|m| m.poisson)),
            strength: take("strength", written.strength, of(|m| m.strength)),
            fracture_energy: take(
                "fracture_energy",
                written.fracture_energy,
                of(|m| m.fracture_energy),
            ),
            weibull: written.weibull.or(of(|m| m.weibull)).unwrap_or(DEFAULT_WEIBULL),
            correlation: written.correlation,
            weak_plane: written.weak_plane,
            layers: written.layers,
            restitution: written
                .restitution
                .or(of(|m| m.restitution))
                .unwrap_or(DEFAULT_RESTITUTION),
            friction: written.friction.or(of(|m| m.friction)).unwrap_or(DEFAULT_FRICTION),
            // What follows from the rest is put in below.
            surface: SurfaceLaw {
                hardness: written.hardness.or(of(|m| m.surface.hardness)).unwrap_or(0.0),
                friction: written.crack_friction.unwrap_or(CRACK_FRICTION),
            },
            breakable: written.breakable.or(base.as_ref().map(|m| m.breakable)).unwrap_or(true),
            treatment: treatment::of_written(written, base.as_ref().and_then(|m| m.treatment)),
            plasticity: written
                .plasticity
                .map(JohnsonCook::from)
                .or(base.as_ref().and_then(|m| m.plasticity)),
            bonds: written.peridynamics.as_ref().map(BondedSolid::from).unwrap_or_default(),
        };
        if material.surface.hardness <= 0.0 {
            material.surface.hardness = material.derived_hardness();
        }
        if missing.is_empty() { Ok(material) } else { Err(missing) }
    }

    /// Hardness of a material that says nothing of it \[Pa\]: three times what it flows at where it
    /// yields, at the strain of a hardness test \[Tabor 1951\], else that of a brittle solid.
    fn derived_hardness(&self) -> f64 {
        match self.plasticity {
            Some(flow) => 3.0 * flow.hardening.stress(TABOR_STRAIN).0,
            None => HARDNESS_OVER_STRENGTH * self.strength,
        }
    }

    /// What a solver needs to know of it.
    #[must_use]
    pub fn solid(&self) -> Material {
        Material {
            density: self.density,
            young: self.young,
            poisson: self.poisson,
            failure_stress: self.strength,
            fracture_energy: self.fracture_energy,
        }
    }

    /// What forbids rigid bodies of it to break: they do at small strains.
    pub(super) fn rigid_faults(&self) -> Vec<Fault> {
        match self.beyond(STRENGTH_OVER_YOUNG) {
            Some(fault) => vec![fault],
            None => self.faults(),
        }
    }

    /// What forbids any body of it to break.
    pub(super) fn faults(&self) -> Vec<Fault> {
        match self.beyond((STRENGTH_OVER_YOUNG.0, MOST_STRETCHY)) {
            Some(fault) => vec![fault],
            None => self.flow_faults(),
        }
    }

    /// Why its strength over Young's modulus does not hold, if it is out of these bounds.
    fn beyond(&self, (low, high): (f64, f64)) -> Option<Fault> {
        let ratio = self.strength / self.young;
        if (low..=high).contains(&ratio) {
            return None;
        }
        let message = format!(
            "strength over Young's modulus must lie in [{}, {}]; it is {ratio:.3e} ({} Pa / {} Pa)",
            tell(low),
            tell(high),
            tell(self.strength),
            tell(self.young)
        );
        Some(("strength", message))
    }

    /// What of its flow does not hold: its keys have bounds of their own, but for `failure`.
    fn flow_faults(&self) -> Vec<Fault> {
        let bounds = self.plasticity.iter().flat_map(JohnsonCook::bounds);
        let wrong = bounds.filter(|(_, value, low, high)| !(low..=high).contains(&value));
        let told = wrong.map(|(what, value, low, high)| {
            let message =
                format!("{what} must lie in [{}, {}]; it is {value}", tell(low), tell(high));
            ("plasticity", message)
        });
        told.collect()
    }

    /// Normals that have no direction.
    pub(super) fn directions(&self) -> Vec<Fault> {
        let weak = self.weak_plane.map(|weak| ("weak_plane", weak.normal));
        let layers = self.layers.map(|layers| ("layers", layers.normal));
        let bad = |(key, normal)| direction(normal).err().map(|why| (key, why.to_owned()));
        weak.into_iter().chain(layers).filter_map(bad).collect()
    }

    /// What is unusual about it.
    pub(super) fn doubts(&self) -> Vec<Fault> {
        let mut doubts = Vec::new();
        let toughness = (self.young * self.fracture_energy).sqrt();
        let (low, high) = TOUGHNESS;
        // What only flows is not torn by its toughness; what has `failure` is.
        let tears = self.plasticity.is_none_or(|flow| flow.failure.is_some());
        // What is so soft is no structural solid, of which the bounds are.
        let cracks = self.breakable && tears && self.young >= SOFT;
        if cracks && !(low..=high).contains(&toughness) {
            doubts.push((
                "fracture_energy",
                format!(
                    "K_Ic = √(E·G_f) is {:.3} MPa√m; it usually lies in [{}, {}]",
                    toughness / 1e6,
                    low / 1e6,
                    high / 1e6
                ),
            ));
        }
        let speed = self.wave_speed();
        if speed > WAVE_SPEED {
            doubts.push((
                "young",
                format!(
                    "pressure waves would run at {speed:.0} m/s; usual is at most {WAVE_SPEED}"
                ),
            ));
        }
        doubts
    }

    /// Speed of pressure waves, √(E(1−ν)/(ρ(1+ν)(1−2ν))) \[m/s\].
    #[must_use]
    pub fn wave_speed(&self) -> f64 {
        let nu = self.poisson;
        let modulus = self.young * (1.0 - nu) / ((1.0 + nu) * (1.0 - 2.0 * nu));
        (modulus / self.density).sqrt()
    }
}
