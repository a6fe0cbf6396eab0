//! Treatments of glass: those of the presets, with a source for every value, and what a scene makes
//! of them.

use super::format::{self, GlassTreatment, SolverChoice};
use super::sourced::{Fault, Kind, Sourced};
use cullet_geometry::Solid;
use cullet_model::{Interlayer, Treatment};
use cullet_plan::family;

const EN_1863: &str = "ASTM C1048 and EN 1863-1: 24 to 52 MPa; not read here";
const EN_12150: &str = "ASTM C1048: 69 MPa or more; usual plates have 80 to 120; not read here";
const PVB: &str = "two layers of polyvinyl butyral, the usual film; no measurement was read";
const PVB_TEARS: &str = "polyvinyl butyral: about 20 MPa at twice to three times its length";

const fn typical(value: f64, source: &'static str) -> Sourced {
    Sourced { value, kind: Kind::Typical, source }
}

/// What was done to the glass of a preset.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
#[serde(rename_all = "kebab-case", tag = "kind")]
pub enum PresetTreatment {
    /// Faces under pressure.
    HeatStrengthened {
        /// Pressure at the faces \[Pa\].
        surface_stress: Sourced,
    },
    /// Faces under so much that it dices.
    Toughened {
        /// Pressure at the faces \[Pa\].
        surface_stress: Sourced,
    },
    /// Plies on a film.
    Laminated {
        /// Thickness of the film \[m\].
        thickness: Sourced,
        /// Tension at which it tears \[Pa\].
        strength: Sourced,
        /// Length at which it tears over its first length \[1\].
        stretch: Sourced,
    },
}

/// The default of heat-strengthened glass.
pub(super) const HEAT_STRENGTHENED: PresetTreatment =
    PresetTreatment::HeatStrengthened { surface_stress: typical(40e6, EN_1863) };

/// The default of toughened glass.
pub(super) const TOUGHENED: PresetTreatment =
    PresetTreatment::Toughened { surface_stress: typical(90e6, EN_12150) };

/// The default of laminated glass.
pub(super) const LAMINATED: PresetTreatment = PresetTreatment::Laminated {
    thickness: typical(0.76e-3, PVB),
    strength: typical(20e6, PVB_TEARS),
    stretch: typical(2.0, PVB_TEARS),
};

impl From<PresetTreatment> for Treatment {
    fn from(preset: PresetTreatment) -> Self {
        match preset {
            PresetTreatment::HeatStrengthened { surface_stress } => {
                Self::HeatStrengthened { surface_stress: surface_stress.value }
            }
            PresetTreatment::Toughened { surface_stress } => {
                Self::Toughened { surface_stress: surface_stress.value }
            }
            PresetTreatment::Laminated { thickness, strength, stretch } => {
                let [thickness, strength, stretch] =
                    [thickness, strength, stretch].map(|number| number.value);
                Self::Laminated { interlayer: Interlayer { thickness, strength, stretch } }
            }
        }
    }
}

/// What a written material was treated with, on what its preset was.
pub(super) fn of_written(
    written: &format::Material,
    preset: Option<Treatment>,
) -> Option<Treatment> {
    let default = match written.treatment {
        None => preset?,
        Some(GlassTreatment::Annealed) => return None,
        Some(GlassTreatment::HeatStrengthened) => HEAT_STRENGTHENED.into(),
        Some(GlassTreatment::Toughened) => TOUGHENED.into(),
        Some(GlassTreatment::Laminated) => LAMINATED.into(),
    };
    // The preset's own numbers, where it is the same treatment.
    let alike = preset.filter(|preset| preset.kind() == default.kind());
    let (mut treatment, film) = (alike.unwrap_or(default), written.interlayer.unwrap_or_default());
    match &mut treatment {
        Treatment::HeatStrengthened { surface_stress }
        | Treatment::Toughened { surface_stress } => {
            *surface_stress = written.surface_stress.unwrap_or(*surface_stress);
        }
        Treatment::Laminated { interlayer } => {
            interlayer.thickness = film.thickness.unwrap_or(interlayer.thickness);
            interlayer.strength = film.strength.unwrap_or(interlayer.strength);
            interlayer.stretch = film.stretch.unwrap_or(interlayer.stretch);
        }
        _ => {}
    }
    Some(treatment)
}

/// Keys that say nothing of a material of that treatment, or of one that `yields`.
pub(super) fn misplaced(
    written: &format::Material,
    treatment: Option<&Treatment>,
    yields: bool,
) -> Vec<Fault> {
    let laminated = matches!(treatment, Some(Treatment::Laminated { .. }));
    let mut faults = Vec::new();
    if written.surface_stress.is_some() && (treatment.is_none() || laminated) {
        let message = "is of `heat-strengthened` or `toughened` glass: say so by `treatment`";
        faults.push(("surface_stress", message.to_owned()));
    }
    if written.interlayer.is_some() && !laminated {
        faults.push(("interlayer", "is of `laminated` glass: say so by `treatment`".to_owned()));
    }
    if let Some(treatment) = treatment.filter(|_| yields) {
        faults.push(("plasticity", format!("{} does not yield", treatment.kind())));
    }
    let written_keys =
        [("weak_plane", written.weak_plane.is_some()), ("layers", written.layers.is_some())];
    for (key, _) in written_keys.into_iter().filter(|(_, is_written)| yields && *is_written) {
        faults.push((key, "a metal that yields has none: it does not crack".to_owned()));
    }
    if let Some(treatment) = treatment
        && written.weak_plane.is_some()
    {
        let message = format!("{} has none: it is solved as a shell", treatment.kind());
        faults.push(("weak_plane", message));
    }
    faults
}

/// Why a body of a material cannot break, by the key at fault.
pub(super) fn unfit(
    treatment: Option<Treatment>,
    solid: &Solid,
    solver: &SolverChoice,
) -> Option<Fault> {
    let kind = treatment.as_ref()?.kind();
    if let Some(name) = solver.name().filter(|name| *name != family::SHELL) {
        return Some(("solver", format!("`{name}` takes no {kind}: `{}` does", family::SHELL)));
    }
    let flat = cullet_plan::thin_plate(&solid.mesh).err()?;
    let (form, why) = match treatment {
        Some(Treatment::Toughened { .. }) => ("flat thin plate", flat),
        _ => ("thin plate or wall", cullet_plan::thin_wall(solid).err()?),
    };
    let cure = "make it one, or give it annealed glass or `breakable = false`";
    Some(("material", format!("{kind} breaks only as a {form}, and {why}: {cure}")))
}
