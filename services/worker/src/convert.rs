//! The wire's twins to the core's types and back.

use cullet_fracture as core;
use cullet_proto as wire;
use std::sync::Arc;

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
    };
    let wire::Settings {
        spacing, max_particles, max_steps, min_volume_ratio, max_fragments, ..
    } = job.settings;
    core::Problem {
        solid: Arc::new(job.solid.clone()),
        material: core::Material { density, young, poisson, failure_stress, fracture_energy },
        impacts: job.impacts.iter().map(impact).collect(),
        settings: core::Settings {
            spacing,
            max_particles,
            max_steps,
            min_volume_ratio,
            max_fragments,
            detail: detail_of(job.settings.detail),
        },
        seed: job.seed,
    }
}

fn detail_of(detail: wire::Detail) -> core::detail::Detail {
    core::detail::Detail {
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

/// The body that a solve took apart, with the reason why another family did not.
#[must_use]
pub fn fracture_of(fracture: core::Fracture, refusal: Option<String>) -> wire::BrokenBody {
    let fragment = |f: core::Fragment| wire::Fragment {
        solid: f.solid,
        hulls: f.hulls,
        velocity: f.velocity,
        spin: f.spin,
    };
    let report = fracture.report;
    wire::BrokenBody {
        fragments: fracture.fragments.into_iter().map(fragment).collect(),
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
