//! The wire's twins to the core's types and back.

use cullet_geometry::Vec3;
use cullet_model as core;
use cullet_model::strength as field;
use cullet_proto as wire;
use cullet_proto::strength as twin;
use std::sync::Arc;

/// Names of the families that a worker of this program solves.
#[must_use]
pub fn solvers() -> Vec<&'static str> {
    crate::families::FAMILIES.iter().map(|entry| entry.name).collect()
}

/// The problem of a job.
#[must_use]
pub fn problem_of(job: &wire::FractureJob) -> core::Problem {
    let wire::Material { density, young, poisson, failure_stress, fracture_energy } = job.material;
    let impact = |i: &wire::Impact| core::Impact {
        point: i.point,
        normal: i.normal,
        impulse: i.impulse,
        duration: i.duration,
        radius: i.radius,
        energy: i.energy,
        closing_speed: i.closing_speed,
        crushing_pressure: i.crushing_pressure,
    };
    let support = |s: &wire::Support| core::Support {
        point: Vec3::from(s.point),
        normal: Vec3::from(s.normal),
        radius: s.radius,
        mobility: s.mobility,
    };
    let settings = job.settings;
    core::Problem {
        solid: Arc::new(job.solid.clone()),
        material: core::Material { density, young, poisson, failure_stress, fracture_energy },
        strength: strength_of(&job.strength),
        impacts: job.impacts.iter().map(impact).collect(),
        supports: job.supports.iter().map(support).collect(),
        spin: job.spin,
        settings: core::Settings {
            spacing: settings.spacing,
            max_particles: settings.max_particles,
            max_steps: settings.max_steps,
            min_volume_ratio: settings.min_volume_ratio,
            max_fragments: settings.max_fragments,
            debris: settings.debris,
            grain: settings.grain,
            hairline: settings.hairline,
            detail: detail_of(settings.detail),
            precision: match settings.precision {
                wire::Precision::Single => core::Precision::Single,
                wire::Precision::Double => core::Precision::Double,
            },
            error: settings.error,
        },
        seed: job.seed,
    }
}

fn detail_of(detail: wire::Detail) -> core::Detail {
    core::Detail {
        edge: detail.edge,
        length: detail.length,
        influence: detail.influence,
        grid: detail.grid,
        height: detail.height,
        share: detail.share,
        ribs: detail.ribs,
        rib_spacing: detail.rib_spacing,
        grain: detail.grain,
        grain_size: detail.grain_size,
    }
}

/// The strength field of a job.
pub(crate) fn strength_of(wire: &twin::Strength) -> core::StrengthField {
    let vertices = wire.vertices.as_ref().map(|paint| field::VertexPaint {
        points: paint.points.clone(),
        factors: paint.factors.clone(),
        reach: paint.reach,
    });
    core::StrengthField {
        seed: wire.seed,
        weibull: wire.weibull,
        correlation: wire.correlation,
        offset: Vec3::from(wire.offset),
        weak_plane: wire.weak_plane.map(|weak| (Vec3::from(weak.normal), weak.ratio)),
        layers: wire.layers.map(|layers| field::Layers {
            normal: Vec3::from(layers.normal),
            thickness: layers.thickness,
            ratio: layers.ratio,
            jitter: layers.jitter,
        }),
        strokes: wire.strokes.iter().map(stroke_of).collect(),
        vertices: vertices.map(Arc::new),
    }
}

fn stroke_of(wire: &twin::Stroke) -> field::Stroke {
    field::Stroke { region: region_of(&wire.region), factor: wire.factor, edge: wire.edge }
}

pub(crate) fn region_of(wire: &twin::Region) -> field::Region {
    match *wire {
        twin::Region::Box(low, high) => {
            field::Region::Box { low: Vec3::from(low), high: Vec3::from(high) }
        }
        twin::Region::Sphere(centre, radius) => {
            field::Region::Sphere { centre: Vec3::from(centre), radius }
        }
        twin::Region::HalfSpace(point, normal) => {
            field::Region::HalfSpace { point: Vec3::from(point), normal: Vec3::from(normal) }
        }
        twin::Region::Cylinder(from, to, radius) => {
            field::Region::Cylinder { from: Vec3::from(from), to: Vec3::from(to), radius }
        }
    }
}

/// The body that a solve took apart, with the reason why another family did not.
#[must_use]
pub fn fracture_of(fracture: core::Fracture, refusal: Option<String>) -> wire::BrokenBody {
    let fragment = |f: core::Fragment| wire::Fragment {
        solid: f.solid,
        hulls: f.hulls,
        velocity: f.velocity,
        spin: f.spin,
        sheet: f.sheet,
    };
    let grain = |g: core::Grain| wire::Grain {
        position: g.position,
        velocity: g.velocity,
        volume: g.volume,
        size: g.size,
    };
    let report = fracture.report;
    wire::BrokenBody {
        fragments: fracture.fragments.into_iter().map(fragment).collect(),
        sampled: fracture.sampled,
        debris: fracture.debris.into_iter().map(grain).collect(),
        reactions: fracture.reactions,
        report: wire::Report {
            solver: report.solver,
            refusal,
            spacing: report.spacing,
            particles: report.particles,
            steps: report.steps,
            simulated: report.simulated,
            crack_area: report.crack_area,
            fracture_energy: report.fracture_energy,
            dissipated_energy: report.dissipated_energy,
            strength_ratio: report.strength_ratio,
            damaged_fraction: report.damaged_fraction,
            delivered_impulse: report.delivered_impulse,
            warnings: report.warnings,
        },
    }
}
