//! Matches names against patterns with wildcards.

/// Tests if a name fits a pattern in which `*` stands for any text.
pub fn fits(pattern: &str, name: &str) -> bool {
    let mut parts = pattern.split('*');
    let Some(mut rest) = parts.next().and_then(|first| name.strip_prefix(first)) else {
        return false;
    };
    let parts: Vec<&str> = parts.collect();
    let Some((last, middle)) = parts.split_last() else { return rest.is_empty() };
    for part in middle {
        let Some(place) = rest.find(part) else { return false };
        rest = &rest[place + part.len()..];
    }
    rest.ends_with(last)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patterns_of_names() {
        assert!(fits("leg1.P.mu", "leg1.P.mu") && !fits("leg1.P", "leg1.P.mu"));
        assert!(fits("leg*.P.mu", "leg2.P.mu") && !fits("leg*.P.mu", "leg2.R.mu"));
        assert!(
            fits("*", "anything")
                && fits("*.rod.*", "leg1.rod.mass")
                && !fits("*.rod", "leg1.rod.mass")
        );
    }
}
