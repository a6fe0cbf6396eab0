//! Who may do what over a link: certificates and roles, as settings of the transport (paths and
//! JSON values, as in [`crate::transport`]).
//!
//! A name in a key is the common name of a certificate. Everything that no rule allows is denied: a
//! worker asks as itself and shows its sign of life, a user asks as itself; nobody but the
//! coordinator answers anything. The same rules stand at a coordinator that others connect to, and
//! at a router between them.

use crate::codec::WireError;
use crate::ids::WorkerId;
use crate::keys;
use serde::Deserialize;
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::path::Path;

/// Settings of a transport: paths and JSON values.
pub type Rules = Vec<(&'static str, String)>;

/// Names of the files of an identity, in one folder.
pub const FILES: [&str; 3] = ["ca.pem", "cert.pem", "key.pem"];

/// Mutual TLS with the identity in a folder: the certificate of the authority that signs all, one's
/// own, and its key.
#[must_use]
pub fn identity(folder: &Path) -> Rules {
    let [ca, cert, key] = FILES.map(|name| json!(folder.join(name)).to_string());
    vec![
        ("transport/link/tls/root_ca_certificate", ca),
        ("transport/link/tls/enable_mtls", "true".into()),
        ("transport/link/tls/listen_certificate", cert.clone()),
        ("transport/link/tls/listen_private_key", key.clone()),
        ("transport/link/tls/connect_certificate", cert),
        ("transport/link/tls/connect_private_key", key),
        ("transport/link/tls/verify_name_on_connect", "true".into()),
        ("transport/link/tls/close_link_on_expiration", "true".into()),
    ]
}

/// Who is what, as a file says it: lists of names of certificates.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Names {
    /// May work; `crew-*` is whoever shows the certificate `crew` and is called `crew-…`.
    #[serde(default)]
    pub workers: Vec<String>,
    /// May submit, watch all, and control what is their own.
    #[serde(default)]
    pub users: Vec<String>,
    /// May, as users, and control what is others', and drain workers.
    #[serde(default)]
    pub operators: Vec<String>,
    /// Answers; [`COORDINATOR`] if it is not said.
    #[serde(default)]
    pub coordinator: Option<String>,
    /// What coordinators there are called; [`keys::DEFAULT_COORDINATOR`] if it is not said. All of
    /// them show that certificate.
    #[serde(default)]
    pub names: Vec<String>,
}

/// The name in a coordinator's certificate, where roles name no other.
pub const COORDINATOR: &str = "coordinator";
/// How a coordinator finds others of its name.
const CLAIMS: [&str; 6] = [
    "declare_queryable",
    "query",
    "reply",
    "liveliness_token",
    "liveliness_query",
    "declare_liveliness_subscriber",
];
/// What a name ends with that stands for many workers with one certificate.
const CREW: &str = "-*";

/// Who is what.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Roles {
    workers: BTreeSet<WorkerId>,
    crews: BTreeSet<WorkerId>,
    users: BTreeSet<WorkerId>,
    operators: BTreeSet<WorkerId>,
    coordinator: WorkerId,
    names: BTreeSet<WorkerId>,
}

impl Roles {
    /// Roles from lists of names.
    ///
    /// # Errors
    /// [`WireError::Name`] for one that is none.
    pub fn new(names: &Names) -> Result<Self, WireError> {
        let all = |names: &[String]| -> Result<BTreeSet<WorkerId>, WireError> {
            names.iter().map(|name| WorkerId::new(name)).collect()
        };
        let crew = |name: &String| name.strip_suffix(CREW).map(str::to_owned);
        let crews: Vec<String> = names.workers.iter().filter_map(crew).collect();
        let workers: Vec<String> =
            names.workers.iter().filter(|name| crew(name).is_none()).cloned().collect();
        let operators = all(&names.operators)?;
        let users = all(&names.users)?.union(&operators).cloned().collect();
        let coordinator = WorkerId::new(names.coordinator.as_deref().unwrap_or(COORDINATOR))?;
        // A coordinator's own workers show its certificate.
        let mut crews = all(&crews)?;
        crews.insert(coordinator.clone());
        let mut called = all(&names.names)?;
        if called.is_empty() {
            called.insert(WorkerId::new(keys::DEFAULT_COORDINATOR)?);
        }
        let workers = all(&workers)?;
        Ok(Self { workers, crews, users, operators, coordinator, names: called })
    }

    /// The name in the coordinator's certificate.
    #[must_use]
    pub fn coordinator(&self) -> &WorkerId {
        &self.coordinator
    }

    /// What coordinators are called.
    #[must_use]
    pub fn names(&self) -> &BTreeSet<WorkerId> {
        &self.names
    }

    /// Who may control what is others'.
    #[must_use]
    pub fn operators(&self) -> &BTreeSet<WorkerId> {
        &self.operators
    }

    /// Who may submit and watch all: users and operators.
    #[must_use]
    pub fn users(&self) -> &BTreeSet<WorkerId> {
        &self.users
    }

    /// The rules of a router, or of a coordinator that is one.
    #[must_use]
    pub fn access(&self) -> Rules {
        let each = |key: &dyn Fn(&WorkerId) -> String| -> Vec<String> {
            self.names.iter().map(key).collect()
        };
        let mut control = Control::default();
        for name in &self.workers {
            let asks = each(&|coordinator| keys::worker_rpcs_of(coordinator, name));
            let lives = each(&|coordinator| keys::worker_lives(coordinator, name));
            control.admit("w", name, &asking(&asks, &lives));
        }
        for name in &self.crews {
            let asks = each(&|coordinator| keys::crew_rpcs(coordinator, name));
            let lives = each(&|coordinator| keys::crew_lives(coordinator, name));
            control.admit("crew", name, &asking(&asks, &lives));
        }
        for name in &self.users {
            let asks = each(&|coordinator| keys::user_rpcs_of(coordinator, name));
            control.admit("u", name, &asking(&asks, &[]));
        }
        let answers = [each(&keys::worker_rpcs), each(&keys::user_rpcs)].concat();
        let sees = each(&keys::workers_live);
        let others = [each(&keys::claims), each(&keys::coordinators_live)].concat();
        let rights: [Right<'_>; 6] = [
            ("answers", &["declare_queryable", "reply"], "ingress", &answers),
            ("is-asked", &["query"], "egress", &answers),
            ("watches", &["declare_liveliness_subscriber"], "ingress", &sees),
            ("sees", &["liveliness_token"], "egress", &sees),
            ("claims", &CLAIMS, "ingress", &others),
            ("meets", &["query", "reply", "liveliness_token"], "egress", &others),
        ];
        control.admit("c", &self.coordinator, &rights);
        vec![("access_control", control.json().to_string())]
    }
}

/// A right: what it is called, which messages, which way, under which keys.
type Right<'a> = (&'static str, &'static [&'static str], &'static str, &'a [String]);

/// Asks under some keys, and shows signs of life under others.
fn asking<'a>(asks: &'a [String], lives: &'a [String]) -> Vec<Right<'a>> {
    let mut rights: Vec<Right<'a>> =
        vec![("asks", &["query"], "ingress", asks), ("hears", &["reply"], "egress", asks)];
    if !lives.is_empty() {
        rights.push(("lives", &["liveliness_token"], "ingress", lives));
    }
    rights
}

/// Rules, who there is, and which rules are for whom.
#[derive(Default)]
struct Control {
    rules: Vec<Value>,
    subjects: Vec<Value>,
    policies: Vec<Value>,
}

impl Control {
    /// Gives rights to the certificate of that name.
    fn admit(&mut self, side: &str, name: &WorkerId, rights: &[Right<'_>]) {
        let id = format!("{side}-{name}");
        let ids: Vec<String> = rights.iter().map(|right| format!("{id}-{}", right.0)).collect();
        for ((_, messages, flow, keys), id) in rights.iter().zip(&ids) {
            self.rules.push(json!({
                "id": id,
                "messages": messages,
                "flows": [flow],
                "permission": "allow",
                "key_exprs": keys,
            }));
        }
        self.subjects.push(json!({"id": id, "cert_common_names": [name.as_str()]}));
        self.policies.push(json!({"rules": ids, "subjects": [id]}));
    }

    fn json(&self) -> Value {
        json!({
            "enabled": true,
            "default_permission": "deny",
            "rules": self.rules,
            "subjects": self.subjects,
            "policies": self.policies,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::{Names, Roles};
    use crate::codec::WireError;
    use serde_json::Value;

    fn names(workers: &[&str], users: &[&str], operators: &[&str]) -> Names {
        let [workers, users, operators] = [workers, users, operators]
            .map(|list| list.iter().map(|name| (*name).to_owned()).collect());
        Names { workers, users, operators, ..Names::default() }
    }

    #[test]
    fn coordinators_of_several_names_have_the_same_rights_each() -> Result<(), WireError> {
        let several =
            Names { names: vec!["main".into(), "night".into()], ..names(&["w-1"], &["ann"], &[]) };
        let one = Roles::new(&names(&["w-1"], &["ann"], &[]))?.access();
        let two = Roles::new(&several)?.access();
        let keys = |text: &str| -> Vec<Vec<String>> {
            let said: Value = serde_json::from_str(text).unwrap_or_default();
            let rules = said["rules"].as_array().cloned().unwrap_or_default();
            let keys =
                rules.into_iter().map(|rule| serde_json::from_value(rule["key_exprs"].clone()));
            keys.map(Result::unwrap_or_default).collect()
        };
        let (one, two) = (keys(&one[0].1), keys(&two[0].1));
        assert!(one.len() == two.len() && one.len() > 6);
        for (one, two) in one.iter().zip(&two) {
            let night = one.iter().map(|key| key.replace("/main/", "/night/"));
            let mut want: Vec<String> = one.iter().cloned().chain(night).collect();
            let mut have = two.clone();
            want.sort();
            have.sort();
            assert_eq!(have, want);
        }
        Ok(())
    }

    #[test]
    fn each_may_ask_as_itself_and_nothing_else() -> Result<(), WireError> {
        // Who is named twice has one rule, and an operator may what a user may.
        let roles = Roles::new(&names(&["w-1", "pod-*"], &["ann", "ann"], &["ann"]))?;
        let access = roles.access();
        let said: Value = serde_json::from_str(&access[0].1).unwrap_or_default();
        assert_eq!((said["enabled"].as_bool(), access.len()), (Some(true), 1));
        assert_eq!(said["default_permission"], "deny");
        let rows: Vec<String> = said["rules"]
            .as_array()
            .into_iter()
            .flatten()
            .map(|r| format!("{} {} {}", r["messages"], r["flows"][0], r["key_exprs"]))
            .map(|row| row.replace(['"', '[', ']'], ""))
            .collect();
        let all = "cullet/v1/c/main/rpc/w/**,cullet/v1/c/main/rpc/u/**";
        let others = "cullet/v1/c/main/claim/*,cullet/v1/live/c/main/*";
        let shown = "declare_queryable,query,reply,liveliness_token";
        let want = [
            "query ingress cullet/v1/c/main/rpc/w/w-1/**",
            "reply egress cullet/v1/c/main/rpc/w/w-1/**",
            "liveliness_token ingress cullet/v1/live/w/main/w-1/*",
            "query ingress cullet/v1/c/main/rpc/w/coordinator-$*/**",
            "reply egress cullet/v1/c/main/rpc/w/coordinator-$*/**",
            "liveliness_token ingress cullet/v1/live/w/main/coordinator-$*/*",
            "query ingress cullet/v1/c/main/rpc/w/pod-$*/**",
            "reply egress cullet/v1/c/main/rpc/w/pod-$*/**",
            "liveliness_token ingress cullet/v1/live/w/main/pod-$*/*",
            "query ingress cullet/v1/c/main/rpc/u/ann/**",
            "reply egress cullet/v1/c/main/rpc/u/ann/**",
            &format!("declare_queryable,reply ingress {all}"),
            &format!("query egress {all}"),
            "declare_liveliness_subscriber ingress cullet/v1/live/w/main/*/*",
            "liveliness_token egress cullet/v1/live/w/main/*/*",
            &format!("{shown},liveliness_query,declare_liveliness_subscriber ingress {others}"),
            &format!("query,reply,liveliness_token egress {others}"),
        ];
        assert_eq!(rows, want);
        assert_eq!(said["policies"][0]["subjects"][0], "w-w-1");
        let subjects = |k: usize| said["subjects"][k]["cert_common_names"][0].clone();
        assert_eq!([1, 2, 3, 4].map(subjects), ["coordinator", "pod", "ann", "coordinator"]);
        for bad in ["a/b", "*", "-*", "a*", "$*-*"] {
            assert!(Roles::new(&names(&[bad], &[], &[])).is_err(), "{bad}");
        }
        Ok(())
    }
}
