//! What a specimen is made of: a material, and others in zones.

use super::builder::{SpecimenBuilder, Use};
use super::format::SpecimenDocument;
use super::paths::{below, item, path};
use cullet_document::tree::Path;
use cullet_geometry::Vec3;
use cullet_model::strength::{EVEN, StrengthLayers};
use cullet_model::{Hardening, PatternWeakPlane, StrengthField};
use cullet_scene::format::Material as Written;
use cullet_scene::material::SceneMaterial;
use cullet_scene::resolve::own_material;
use cullet_specimen::Zone;

/// Strength and fracture energy of a material that cannot break and gives none.
const UNBREAKABLE: (f64, f64) = (1e-3, 1e3);

impl SpecimenBuilder<'_> {
    /// A material, without strength where nothing can break.
    fn material(&mut self, written: &Written, breaks: bool, at: &Path) -> Option<SceneMaterial> {
        let mut written = written.clone();
        if !breaks {
            written.breakable = Some(false);
            if written.preset.is_none() {
                let young = written.young.unwrap_or(1.0);
                written.strength.get_or_insert(UNBREAKABLE.0 * young);
                written.fracture_energy.get_or_insert(UNBREAKABLE.1);
            }
        }
        own_material(&mut self.shop, &written, at)
    }

    pub(super) fn zones(&mut self, document: &SpecimenDocument) -> Vec<Zone> {
        let mut zones = Vec::new();
        for (index, zone) in document.zone.iter().enumerate() {
            let at = item("zone", index);
            let part = self.region(&zone.region, &at, Use::Points);
            let own = below(&at, "material");
            for (key, given) in [
                ("weibull", zone.material.weibull.is_some()),
                ("correlation", zone.material.correlation.is_some()),
                ("weak_plane", zone.material.weak_plane.is_some()),
                ("layers", zone.material.layers.is_some()),
                ("plasticity", zone.material.plasticity.is_some()),
                ("hardness", zone.material.hardness.is_some()),
                ("crack_friction", zone.material.crack_friction.is_some()),
            ] {
                if given {
                    self.wrong(&below(&own, key), format!("a zone takes no `{key}`"));
                }
            }
            let made = self.material(&zone.material, document.solver.breaks, &own);
            zones.extend(made.map(|made| Zone { part, material: made.solid() }));
        }
        zones
    }

    /// Its material, how it yields, and how its strength varies.
    pub(super) fn whole(
        &mut self,
        document: &SpecimenDocument,
    ) -> Option<(SceneMaterial, Option<Hardening>, StrengthField)> {
        let at = path(&["material"]);
        let Some(written) = &document.material else {
            self.wrong(&[], "`material` is missing");
            return None;
        };
        let made = self.material(written, document.solver.breaks, &at)?;
        let weak = made.weak_plane.map(|plane| (plane.normal, plane.ratio));
        let layers = made.layers;
        let strength = StrengthField {
            seed: document.solver.seed,
            weibull: if document.solver.flaws { made.weibull } else { EVEN },
            correlation: made.correlation,
            weak_plane: weak
                .map(|(normal, ratio)| PatternWeakPlane { normal: self.unit(normal, &at), ratio }),
            layers: layers.map(|layers| StrengthLayers {
                normal: self.unit(layers.normal, &at),
                thickness: layers.thickness,
                ratio: layers.ratio,
                jitter: layers.jitter,
            }),
            offset: Vec3::zeros(),
            strokes: Vec::new(),
            vertices: None,
        };
        // Slow and cold.
        let hardening = made.plasticity.map(|flow| flow.hardening);
        Some((made, hardening, strength))
    }
}
