//! Materials: the presets with a source for every value, and what a scene makes of them.

use super::direction::direction;
use super::format::{
    self, DEFAULT_FRICTION, DEFAULT_RESTITUTION, DEFAULT_WEIBULL, Layers, WeakPlane,
};
use cullet_document::check::tell;

/// How a value was come by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// Measured, and read in the source that is named.
    Measured,
    /// The usual size of it; no measurement was read.
    Typical,
}

/// A value, how it was come by, and where it stands.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Sourced {
    /// In SI.
    pub value: f64,
    /// Measured or typical.
    pub kind: Kind,
    /// Where it stands, or what it was computed from.
    pub source: &'static str,
}

/// A material that scenes can name without describing it.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Preset {
    /// What scenes call it.
    pub name: &'static str,
    /// What exactly it is.
    pub title: &'static str,
    /// Mass density ρ \[kg/m³\].
    pub density: Sourced,
    /// Young's modulus E \[Pa\].
    pub young: Sourced,
    /// Poisson's ratio ν \[1\].
    pub poisson: Sourced,
    /// Tensile strength σ_f \[Pa\].
    pub strength: Sourced,
    /// Mode I fracture energy G_f \[J/m²\].
    pub fracture_energy: Sourced,
    /// Weibull modulus m of the flaws \[1\].
    pub weibull: Sourced,
    /// Speed after over speed before a bounce \[1\].
    pub restitution: Sourced,
    /// Coulomb friction \[1\].
    pub friction: Sourced,
    /// Whether bodies of it break unless they say otherwise: strikers do not.
    pub breakable: bool,
}

const DOWLING: &str = "Dowling, Mechanical Behavior of Materials, Table 3.10";
const DOWLING_K: &str = "G = K²(1-ν²)/E with K_Ic of Dowling, Table 8.2, and a typical ν";
const MODEL_CODE: &str = "CEB-FIP Model Code 1990 for C30, 16 mm aggregate";
const PETROVIC: &str = "Petrovic 2003, J. Mater. Sci. 38: middle of 0.7 to 3.1 MPa at -10 °C";
const PETROVIC_K: &str = "G = K²(1-ν²)/E with K_Ic 0.1 MPa√m of Petrovic 2003 (0.05 to 0.15)";
const TEXTBOOK: &str = "usual textbook value";
const STRIKER: &str = "usual textbook value; a striker, not meant to break";
const SCENES: &str = "chosen for scenes; depends on shape, finish and speed";

const CERAMIC: &str = "ceramics scatter with 5 to 20; no measurement of this one was read";
const GLASS: &str = "annealed glass scatters with 5 to 10, by its surface; no measurement was read";
const ROCK: &str = "rocks scatter with 10 to 20; no measurement of this one was read";
const TOUGH: &str = "tough solids scatter little, above 20; no measurement of this one was read";
const WIDE: &str = "scatters widely with grain and bubbles; no measurement was read";

const fn measured(value: f64, source: &'static str) -> Sourced {
    Sourced { value, kind: Kind::Measured, source }
}

const fn typical(value: f64, source: &'static str) -> Sourced {
    Sourced { value, kind: Kind::Typical, source }
}

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

const PRESETS: &[Preset] = &[
    Preset {
        name: "alumina",
        title: "alumina, 99.5 %",
        density: measured(3890.0, DOWLING),
        young: measured(372e9, DOWLING),
        poisson: typical(0.22, TEXTBOOK),
        strength: measured(262e6, DOWLING),
        fracture_energy: measured(40.9, DOWLING_K),
        weibull: typical(10.0, CERAMIC),
        restitution: typical(0.5, SCENES),
        friction: typical(0.4, SCENES),
        breakable: true,
    },
    Preset {
        name: "brick",
        title: "fired clay brick",
        density: typical(1900.0, TEXTBOOK),
        young: typical(15e9, TEXTBOOK),
        poisson: typical(0.15, TEXTBOOK),
        strength: typical(2.4e6, TEXTBOOK),
        fracture_energy: typical(80.0, "van der Pluijm: 60 to 130 J/m²; not read here"),
        weibull: typical(8.0, CERAMIC),
        restitution: typical(0.2, SCENES),
        friction: typical(0.65, SCENES),
        breakable: true,
    },
    Preset {
        name: "concrete",
        title: "concrete, C30",
        density: typical(2400.0, TEXTBOOK),
        young: typical(33.6e9, MODEL_CODE),
        poisson: typical(0.2, TEXTBOOK),
        strength: typical(2.9e6, MODEL_CODE),
        fracture_energy: typical(76.0, MODEL_CODE),
        weibull: typical(12.0, ROCK),
        restitution: typical(0.2, SCENES),
        friction: typical(0.65, SCENES),
        breakable: true,
    },
    Preset {
        name: "granite",
        title: "granite, Westerly",
        density: measured(2640.0, DOWLING),
        young: measured(49.6e9, DOWLING),
        poisson: typical(0.23, TEXTBOOK),
        strength: measured(9.6e6, DOWLING),
        fracture_energy: measured(15.1, DOWLING_K),
        weibull: typical(18.0, ROCK),
        restitution: typical(0.3, SCENES),
        friction: typical(0.6, SCENES),
        breakable: true,
    },
    Preset {
        name: "ice",
        title: "fresh-water ice, -10 °C",
        density: typical(917.0, TEXTBOOK),
        young: typical(9.3e9, TEXTBOOK),
        poisson: typical(0.33, TEXTBOOK),
        strength: measured(1.0e6, PETROVIC),
        fracture_energy: measured(0.96, PETROVIC_K),
        weibull: typical(5.0, WIDE),
        restitution: typical(0.3, SCENES),
        friction: typical(0.05, SCENES),
        breakable: true,
    },
    Preset {
        name: "limestone",
        title: "limestone, dolomitic",
        density: measured(2790.0, DOWLING),
        young: measured(69e9, DOWLING),
        poisson: typical(0.29, TEXTBOOK),
        strength: measured(19.2e6, DOWLING),
        fracture_energy: measured(22.4, DOWLING_K),
        weibull: typical(16.0, ROCK),
        restitution: typical(0.3, SCENES),
        friction: typical(0.6, SCENES),
        breakable: true,
    },
    Preset {
        name: "plaster",
        title: "plaster of Paris",
        density: typical(1150.0, TEXTBOOK),
        young: typical(
            4.5e9,
            "depends on porosity: Vekinis, Ashby and Beaumont 1993, not read here",
        ),
        poisson: typical(0.22, TEXTBOOK),
        strength: typical(
            2.5e6,
            "depends on porosity: Vekinis, Ashby and Beaumont 1993, not read here",
        ),
        fracture_energy: typical(
            4.1,
            "depends on porosity: Vekinis, Ashby and Beaumont 1993, not read here",
        ),
        weibull: typical(8.0, CERAMIC),
        restitution: typical(0.2, SCENES),
        friction: typical(0.6, SCENES),
        breakable: true,
    },
    Preset {
        name: "pmma",
        title: "PMMA (acrylic glass)",
        density: typical(1190.0, TEXTBOOK),
        young: typical(3.0e9, TEXTBOOK),
        poisson: typical(0.37, TEXTBOOK),
        strength: typical(70e6, TEXTBOOK),
        fracture_energy: measured(932.0, DOWLING_K),
        weibull: typical(20.0, TOUGH),
        restitution: typical(0.5, SCENES),
        friction: typical(0.4, SCENES),
        breakable: true,
    },
    Preset {
        name: "porcelain",
        title: "porcelain, zircon",
        density: measured(3600.0, DOWLING),
        young: measured(147e9, DOWLING),
        poisson: typical(0.2, TEXTBOOK),
        strength: measured(56e6, DOWLING),
        fracture_energy: typical(11.0, "G = K²(1-ν²)/E with a typical K_Ic of 1.3 MPa√m"),
        weibull: typical(12.0, CERAMIC),
        restitution: typical(0.4, SCENES),
        friction: typical(0.4, SCENES),
        breakable: true,
    },
    Preset {
        name: "rubber",
        title: "natural rubber, filled",
        density: typical(1100.0, STRIKER),
        young: typical(5e6, STRIKER),
        poisson: typical(0.49, STRIKER),
        strength: typical(15e6, STRIKER),
        fracture_energy: typical(1e4, STRIKER),
        weibull: typical(20.0, TOUGH),
        restitution: typical(0.8, SCENES),
        friction: typical(0.9, SCENES),
        breakable: false,
    },
    Preset {
        name: "soda-lime-glass",
        title: "soda-lime glass",
        density: measured(2480.0, DOWLING),
        young: measured(74e9, DOWLING),
        poisson: typical(0.23, TEXTBOOK),
        strength: measured(50e6, DOWLING),
        fracture_energy: measured(7.4, DOWLING_K),
        weibull: typical(7.0, GLASS),
        restitution: typical(0.5, SCENES),
        friction: typical(0.3, SCENES),
        breakable: true,
    },
    Preset {
        name: "steel",
        title: "structural steel",
        density: typical(7850.0, STRIKER),
        young: typical(205e9, STRIKER),
        poisson: typical(0.29, STRIKER),
        strength: typical(450e6, STRIKER),
        fracture_energy: typical(2e4, STRIKER),
        weibull: typical(40.0, TOUGH),
        restitution: typical(0.4, SCENES),
        friction: typical(0.4, SCENES),
        breakable: false,
    },
    Preset {
        name: "stoneware",
        title: "stoneware",
        density: typical(2350.0, TEXTBOOK),
        young: typical(65e9, TEXTBOOK),
        poisson: typical(0.2, TEXTBOOK),
        strength: typical(45e6, TEXTBOOK),
        fracture_energy: typical(17.9, "G = K²(1-ν²)/E with a typical K_Ic of 1.1 MPa√m"),
        weibull: typical(9.0, CERAMIC),
        restitution: typical(0.3, SCENES),
        friction: typical(0.5, SCENES),
        breakable: true,
    },
];

/// The presets as a table for people.
#[must_use]
pub fn presets_text() -> String {
    let mut text = String::from(
        "name             density    E      ν     strength   G_f    weibull restitution friction  \
         breaks\n\
         \x20                [kg/m³]   [GPa]  [1]     [MPa]   [J/m²]    [1]       [1]       [1]\n",
    );
    let mark = |value: &Sourced| {
        if value.kind == Kind::Measured { ' ' } else { '~' }
    };
    for p in PRESETS {
        text.push_str(&format!(
            "{:16} {:>6}{} {:>7}{} {:>5}{} {:>7}{} {:>7}{} {:>5}{} {:>9}{} {:>9}{}   {}\n",
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
    /// Whether bodies of it break unless they say otherwise.
    pub breakable: bool,
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
            breakable: preset.breakable,
        }
    }
}

/// Bounds of σ_f/E \[1\]: outside, a unit was mistaken or the solid is not brittle (F77).
pub(super) const STRENGTH_OVER_YOUNG: (f64, f64) = (1e-5, 1e-1);

/// Usual bounds of K_Ic = √(E·G_f) \[Pa·√m\] (F77).
pub(super) const TOUGHNESS: (f64, f64) = (0.05e6, 200e6);

/// Fastest usual pressure wave \[m/s\] (F77).
pub(super) const WAVE_SPEED: f64 = 12_000.0;

/// A key and what is wrong with it.
pub(super) type Fault = (&'static str, String);

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
        let material = Self {
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
            breakable: written.breakable.or(base.as_ref().map(|m| m.breakable)).unwrap_or(true),
        };
        if missing.is_empty() { Ok(material) } else { Err(missing) }
    }

    /// What forbids bodies of it to break.
    pub(super) fn faults(&self) -> Vec<Fault> {
        let ratio = self.strength / self.young;
        let (low, high) = STRENGTH_OVER_YOUNG;
        if (low..=high).contains(&ratio) {
            return Vec::new();
        }
        let message = format!(
            "strength over Young's modulus must lie in [{}, {}]; it is {ratio:.3e} ({} Pa / {} Pa)",
            tell(low),
            tell(high),
            tell(self.strength),
            tell(self.young)
        );
        vec![("strength", message)]
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
        if self.breakable && !(low..=high).contains(&toughness) {
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
