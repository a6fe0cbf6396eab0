//! Who may do what over a link: certificates and roles, as settings of the transport (paths and
//! JSON values, as in [`crate::transport`]).
//!
//! A name in a key is the common name of a certificate. Everything that no rule allows is denied: a
//! worker asks as itself and shows its sign of life, a user asks as itself; nobody but the
//! coordinator answers anything.

use crate::codec::WireError;
use crate::ids::WorkerId;
use crate::keys;
use serde_json::{Value, json};
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

/// Who is what.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Roles {
    /// May work.
    pub workers: Vec<WorkerId>,
    /// May submit, watch and control.
    pub users: Vec<WorkerId>,
}

impl Roles {
    /// Roles from lists of names.
    ///
    /// # Errors
    /// [`WireError::Name`] for one that is none.
    pub fn new(workers: &[String], users: &[String]) -> Result<Self, WireError> {
        let all = |names: &[String]| -> Result<Vec<WorkerId>, WireError> {
            names.iter().map(|name| WorkerId::new(name)).collect()
        };
        Ok(Self { workers: all(workers)?, users: all(users)? })
    }

    /// The rules of a coordinator that only these may reach.
    #[must_use]
    pub fn access(&self, coordinator: &WorkerId) -> Rules {
        let (mut rules, mut subjects, mut policies) = (Vec::new(), Vec::new(), Vec::new());
        let mut admit = |side: &str, name: &WorkerId, asks: String, lives: Option<String>| {
            let id = format!("{side}-{name}");
            let mut own = vec![
                rule(&format!("{id}-asks"), &["query"], "ingress", &asks),
                rule(&format!("{id}-hears"), &["reply"], "egress", &asks),
            ];
            let alive =
                |key: &String| rule(&format!("{id}-lives"), &["liveliness_token"], "ingress", key);
            own.extend(lives.as_ref().map(alive));
            let ids: Vec<Value> = own.iter().map(|rule| rule["id"].clone()).collect();
            subjects.push(json!({"id": id, "cert_common_names": [name.as_str()]}));
            policies.push(json!({"rules": ids, "subjects": [id]}));
            rules.extend(own);
        };
        for name in &self.workers {
            let lives = keys::worker_lives(coordinator, name);
            admit("w", name, keys::worker_rpcs_of(coordinator, name), Some(lives));
        }
        for name in &self.users {
            admit("u", name, keys::user_rpcs_of(coordinator, name), None);
        }
        let control = json!({
            "enabled": true,
            "default_permission": "deny",
            "rules": rules,
            "subjects": subjects,
            "policies": policies,
        });
        vec![("access_control", control.to_string())]
    }
}

fn rule(id: &str, messages: &[&str], flow: &str, key: &str) -> Value {
    json!({
        "id": id,
        "messages": messages,
        "flows": [flow],
        "permission": "allow",
        "key_exprs": [key],
    })
}

#[cfg(test)]
mod tests {
    use super::Roles;
    use crate::codec::WireError;
    use crate::ids::WorkerId;
    use serde_json::Value;

    #[test]
    fn each_may_ask_as_itself_and_nothing_else() -> Result<(), WireError> {
        let roles = Roles::new(&["w-1".into()], &["ann".into()])?;
        let access = roles.access(&WorkerId::new("main")?);
        let said: Value = serde_json::from_str(&access[0].1).unwrap_or_default();
        assert_eq!((said["enabled"].as_bool(), access.len()), (Some(true), 1));
        assert_eq!(said["default_permission"], "deny");
        let rows: Vec<String> = said["rules"]
            .as_array()
            .into_iter()
            .flatten()
            .map(|r| format!("{} {} {}", r["messages"][0], r["flows"][0], r["key_exprs"][0]))
            .map(|row| row.replace('"', ""))
            .collect();
        let want = [
            "query ingress cullet/v1/c/main/rpc/w/w-1/**",
            "reply egress cullet/v1/c/main/rpc/w/w-1/**",
            "liveliness_token ingress cullet/v1/live/w/main/w-1/*",
            "query ingress cullet/v1/c/main/rpc/u/ann/**",
            "reply egress cullet/v1/c/main/rpc/u/ann/**",
        ];
        assert_eq!(rows, want);
        assert_eq!(said["policies"][0]["subjects"][0], "w-w-1");
        assert_eq!(said["subjects"][1]["cert_common_names"][0], "ann");
        assert!(Roles::new(&["a/b".into()], &[]).is_err());
        Ok(())
    }
}
