//! What happened in a run, as the run loop tells it and as a line for people.

use cullet_geometry::Vec3;
use cullet_proto::recording::{EventKind, Ledger, RunEvent, Vector3, Verdict};
use std::fmt;

/// What Hertz' theory makes of an impact, and what it took.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Touch {
    /// Duration \[s\].
    pub duration: f64,
    /// Greatest radius \[m\].
    pub radius: f64,
    /// Greatest force \[N\].
    pub peak_force: f64,
    /// Kinetic energy that the contact took out of the pair \[J\].
    pub dissipated: f64,
}

/// Something that happened. Bodies are named by id, jobs by the digest of their problem.
#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    /// A contact episode over the threshold.
    Impact {
        /// The body that was hit.
        body: u64,
        /// What hit it.
        striker: u64,
        /// Where, in the world \[m\].
        point: Vec3,
        /// Impulse over the episode \[N·s\].
        impulse: f64,
        /// Closing speed before the contact \[m/s\].
        closing_speed: f64,
        /// Kinetic energy of the approach \[J\].
        energy: f64,
        /// What Hertz' theory makes of it.
        contact: Touch,
    },
    /// The gate kept an impact from a solver.
    Gate {
        /// The body.
        body: u64,
        /// Why no crack can open.
        reason: String,
    },
    /// A fracture job was handed to the pool.
    JobOpened {
        /// The body.
        body: u64,
        /// Digest of the problem.
        job: [u8; 32],
        /// The family asked first.
        solver: String,
        /// Why the gate chose it; empty where it left the choice to the scene.
        reason: String,
        /// Whether the scene gave this hit settings of its own.
        directed: bool,
    },
    /// A fracture job has its verdict.
    JobSettled {
        /// The body.
        body: u64,
        /// Digest of the problem.
        job: [u8; 32],
        /// How it ended.
        verdict: Verdict,
        /// What was said about it; may be empty.
        reason: String,
    },
    /// A body was replaced by fragments.
    Fractured {
        /// The body that is no more.
        parent: u64,
        /// Digest of the problem.
        job: [u8; 32],
        /// The bodies that take its place.
        fragments: Vec<u64>,
        /// Factor on the fragments' own velocities \[1\].
        alpha: f64,
        /// Grains of debris beside them.
        grains: u64,
        /// Their mass \[kg\].
        grain_mass: f64,
        /// What the replacement kept and cost.
        ledger: Ledger,
    },
    /// A body was given a new shape.
    Deformed {
        /// The body.
        body: u64,
        /// Digest of the problem.
        job: [u8; 32],
        /// What this kept and cost.
        ledger: Ledger,
    },
    /// A body stayed whole after a job.
    KeptWhole {
        /// The body.
        body: u64,
        /// Digest of the problem.
        job: [u8; 32],
        /// The reason.
        reason: String,
    },
    /// A body left the world.
    Removed {
        /// The body.
        body: u64,
        /// The reason.
        reason: String,
    },
    /// A joint broke.
    JointBroken {
        /// The joint.
        joint: u64,
        /// One of its bodies.
        body: u64,
        /// The other; nothing stands for the world.
        other: Option<u64>,
        /// Where, in the world \[m\].
        point: Vec3,
        /// Force, the mean over the step \[N\].
        force: f64,
        /// Moment likewise \[N·m\].
        torque: f64,
        /// The load over what the joint bears \[1\].
        share: f64,
    },
    /// A joint went with one of its bodies.
    JointGone {
        /// The joint.
        joint: u64,
        /// One of its bodies.
        body: u64,
        /// The other; nothing stands for the world.
        other: Option<u64>,
        /// The reason.
        reason: String,
    },
    /// What a driven body did to others in the run.
    Driven {
        /// The body.
        body: u64,
        /// Work of its contacts and joints on other bodies \[J\].
        work: f64,
    },
    /// What the scene expected.
    Expectation {
        /// In words.
        text: String,
        /// Whether it held.
        held: bool,
    },
    /// The last step was taken.
    Finished,
}

impl Event {
    /// The message that records it.
    #[must_use]
    pub fn to_message(&self, step: u64, time: f64) -> RunEvent {
        let base = RunEvent { step, time, ..Default::default() };
        let of = |kind: EventKind, body: u64| RunEvent {
            kind: kind as i32,
            body: Some(body),
            ..base.clone()
        };
        match self {
            Self::Impact { body, striker, point, impulse, closing_speed, energy, contact } => {
                RunEvent {
                    duration: contact.duration,
                    radius: contact.radius,
                    peak_force: contact.peak_force,
                    dissipated: contact.dissipated,
                    striker: Some(*striker),
                    point: Some(Vector3 { x: point.x, y: point.y, z: point.z }),
                    impulse: *impulse,
                    closing_speed: *closing_speed,
                    energy: *energy,
                    ..of(EventKind::Impact, *body)
                }
            }
            Self::Gate { body, reason } => {
                RunEvent { text: reason.clone(), ..of(EventKind::Gate, *body) }
            }
            Self::JobOpened { body, job, solver, reason, directed } => RunEvent {
                directed: *directed,
                job: job.to_vec(),
                text: format!("{solver}{}", after_colon(reason)),
                ..of(EventKind::JobOpened, *body)
            },
            Self::JobSettled { body, job, verdict, reason } => RunEvent {
                job: job.to_vec(),
                verdict: *verdict as i32,
                text: reason.clone(),
                ..of(EventKind::JobSettled, *body)
            },
            Self::Fractured { parent, job, fragments, alpha, grains, grain_mass, ledger } => {
                RunEvent {
                    job: job.to_vec(),
                    fragments: fragments.clone(),
                    alpha: *alpha,
                    grains: *grains,
                    grain_mass: *grain_mass,
                    ledger: Some(*ledger),
                    ..of(EventKind::Fractured, *parent)
                }
            }
            Self::Deformed { body, job, ledger } => RunEvent {
                job: job.to_vec(),
                ledger: Some(*ledger),
                ..of(EventKind::Deformed, *body)
            },
            Self::KeptWhole { body, job, reason } => RunEvent {
                job: job.to_vec(),
                text: reason.clone(),
                ..of(EventKind::KeptWhole, *body)
            },
            Self::Expectation { text, held } => RunEvent {
                kind: EventKind::Expectation as i32,
                text: text.clone(),
                held: *held,
                ..base
            },
            Self::Finished => RunEvent { kind: EventKind::Finished as i32, ..base },
            directed => directed.of_directions(base),
        }
    }

    /// The message of what directs a shot.
    fn of_directions(&self, base: RunEvent) -> RunEvent {
        let of = |kind: EventKind, body: u64| RunEvent {
            kind: kind as i32,
            body: Some(body),
            ..base.clone()
        };
        match self {
            Self::JointBroken { joint, body, other, point, force, torque, share } => RunEvent {
                joint: Some(*joint),
                striker: *other,
                point: Some(Vector3 { x: point.x, y: point.y, z: point.z }),
                force: *force,
                torque: *torque,
                load_share: *share,
                ..of(EventKind::JointBroken, *body)
            },
            Self::JointGone { joint, body, other, reason } => RunEvent {
                joint: Some(*joint),
                striker: *other,
                text: reason.clone(),
                ..of(EventKind::JointGone, *body)
            },
            Self::Removed { body, reason } => {
                RunEvent { text: reason.clone(), ..of(EventKind::Removed, *body) }
            }
            Self::Driven { body, work } => {
                RunEvent { energy: *work, ..of(EventKind::Driven, *body) }
            }
            _ => base,
        }
    }
}

/// One line for a person, with its time. `name` turns a body's id into its name.
pub(super) fn line(event: &RunEvent, name: &dyn Fn(u64) -> String) -> String {
    format!("{:9.4} s  {}", event.time, event_text(event, name))
}

/// What happened, as a sentence for a person. `name` turns a body's id into its name.
#[must_use]
pub fn event_text(event: &RunEvent, name: &dyn Fn(u64) -> String) -> String {
    let body = event.body.map_or_else(String::new, name);
    match event.kind() {
        EventKind::Unspecified => "an event of a kind that this version does not know".to_owned(),
        EventKind::Impact => format!(
            "{} hits {body}: {:.4} N·s at {:.3} m/s, {:.4} J",
            event.striker.map_or_else(String::new, name),
            event.impulse,
            event.closing_speed,
            event.energy
        ),
        EventKind::Gate => format!("{body} cannot break: {}", event.text),
        EventKind::JobOpened => {
            format!("job {} opened for {body}, asks {}", Short(&event.job), event.text)
        }
        EventKind::JobSettled => {
            let verdict = format!("{:?}", event.verdict()).to_lowercase();
            format!("job {} for {body} {verdict}{}", Short(&event.job), after_colon(&event.text))
        }
        EventKind::Fractured => {
            let ledger = event.ledger.unwrap_or_default();
            let debris = match event.grains {
                0 => String::new(),
                n => format!(" and {n} grains of {:.3e} kg", event.grain_mass),
            };
            format!(
                "{body} breaks into {}{debris}: crack {:.4} J, α {:.3}, mass error {:.1e}, \
                 momentum {:.1e}",
                event.fragments.len(),
                ledger.fracture_energy,
                event.alpha,
                ledger.mass_rel_error,
                ledger.momentum_rel_error
            )
        }
        EventKind::Deformed => {
            let ledger = event.ledger.unwrap_or_default();
            format!(
                "{body} is deformed: {:.4} J, mass error {:.1e}, momentum {:.1e}",
                ledger.fracture_energy, ledger.mass_rel_error, ledger.momentum_rel_error
            )
        }
        EventKind::KeptWhole => format!("{body} stays whole{}", after_colon(&event.text)),
        EventKind::Removed => format!("{body} leaves the world{}", after_colon(&event.text)),
        EventKind::JointBroken | EventKind::JointGone | EventKind::Driven => {
            directed_text(event, &body, name)
        }
        EventKind::Expectation => {
            format!("expected {}: {}", event.text, if event.held { "held" } else { "NOT HELD" })
        }
        EventKind::Finished => format!("finished after {} steps", event.step),
    }
}

/// What became of a joint or came of a driven body, as a sentence.
fn directed_text(event: &RunEvent, body: &str, name: &dyn Fn(u64) -> String) -> String {
    let joint = event.joint.unwrap_or_default();
    let other = event.striker.map_or_else(|| "the world".to_owned(), name);
    match event.kind() {
        EventKind::JointBroken => format!(
            "joint {joint} of {body} and {other} breaks: {:.4e} N, {:.4e} N·m, {:.2} of what it \
             bears",
            event.force, event.torque, event.load_share
        ),
        EventKind::Driven => format!(
            "{body} was driven by keyframes, and did {:.4e} J of work on others",
            event.energy
        ),
        _ => format!("joint {joint} of {body} and {other} is gone{}", after_colon(&event.text)),
    }
}

fn after_colon(text: &str) -> String {
    if text.is_empty() { String::new() } else { format!(": {text}") }
}

/// The first four bytes of a digest in hexadecimal.
struct Short<'a>(&'a [u8]);

impl fmt::Display for Short<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().take(4).try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}
