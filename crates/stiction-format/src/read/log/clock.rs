//! Parses times of day and dates in logs.

/// Parses a time of day such as `12:05:01.25` and returns it in seconds: from midnight, or from
/// 1970 if a date such as `2024-03-01`, `1.3.2024` or `3/1/2024` precedes the time. An offset from
/// universal time is ignored, because only differences of times matter. Two numbers are minutes and
/// seconds if the second number has decimals (`05:12.25`, also with more than 59 minutes), and hours
/// and minutes after a date.
/// Returns `None` for all other texts, including those that [`is_ambiguous`] accepts.
pub(super) fn seconds(text: &str) -> Option<f64> {
    let (date, time) = match text.split_once(['T', ' ']) {
        Some((date, time)) => (Some(date), time.trim_start()),
        None => (None, text),
    };
    let time = time.trim_end_matches('Z');
    let time = time.rsplit_once(['+', '-']).map_or(time, |(time, _)| time).trim_end();
    let mut parts = time.split(':');
    let whole = |part: &str| part.parse::<u32>().ok();
    let decimal = |part: &str| part.replace(',', ".").parse::<f64>().ok();
    let (first, next) = (whole(parts.next()?)?, parts.next()?);
    let mut is_clock = true;
    let (hour, minute, second) = match (whole(next), parts.next()) {
        (Some(minute), Some(second)) => (first, minute, decimal(second)?),
        (Some(minute), None) => (first, minute, date.map(|_| 0.0)?),
        (None, None) if date.is_none() => {
            is_clock = false;
            (0, first, decimal(next)?)
        }
        _ => return None,
    };
    let is_time = hour < 24 && (minute < 60 || !is_clock) && (0.0..61.0).contains(&second);
    if parts.next().is_some() || !is_time {
        return None;
    }
    let days = date.map_or(Some(0), days)?;
    Some(86_400.0 * days as f64 + 3600.0 * f64::from(hour) + 60.0 * f64::from(minute) + second)
}

/// Seconds of a day, and the last and the first hour of a day, between which midnight is assumed.
const DAY: f64 = 86_400.0;
const EVENING: f64 = 23.0 * 3600.0;
const MORNING: f64 = 3600.0;

/// Count of the midnights that times of day without a date have passed.
#[derive(Debug, Default)]
pub(super) struct Midnights {
    days: f64,
    last: f64,
}

impl Midnights {
    /// Returns the seconds from the first midnight for a time with its value `seconds`, s, from its
    /// own midnight; for times with a date, `seconds`.
    pub(super) fn count(&mut self, text: &str, seconds: f64) -> f64 {
        if text.contains(['T', ' ']) {
            return seconds;
        }
        if self.last >= EVENING && seconds < MORNING {
            self.days += 1.0;
        }
        self.last = seconds;
        self.days * DAY + seconds
    }
}

/// Tests if a text consists of two whole numbers such as `05:12`, which may be hours and minutes or
/// minutes and seconds.
pub(super) fn is_ambiguous(text: &str) -> bool {
    let parts: Option<Vec<u32>> = text.split(':').map(|part| part.parse().ok()).collect();
    parts.is_some_and(|parts| parts.len() == 2 && parts[1] < 60)
}

/// Tests if a text is a time of day, with or without a date, or an ambiguous time
/// ([`is_ambiguous`]).
pub(super) fn is_time(text: &str) -> bool {
    seconds(text).is_some() || is_ambiguous(text)
}

/// Returns the number of days from 1970-01-01 to a date in the Gregorian calendar; `None` for an
/// invalid date.
fn days(date: &str) -> Option<i64> {
    let parts: Vec<i64> =
        date.split(['-', '/', '.']).map(|part| part.parse().ok()).collect::<Option<_>>()?;
    let [a, b, c] = parts[..] else { return None };
    let (year, month, day) = match (a > 31, b > 12 && (a <= 12 || date.contains('/'))) {
        (true, _) => (a, b, c),
        (false, true) => (c, a, b),
        (false, false) if date.contains('/') => (c, a, b),
        (false, false) => (c, b, a),
    };
    // A number above 12 cannot be the month: month and day are then in the other order.
    let (month, day) = if month > 12 { (day, month) } else { (month, day) };
    if !(1..=12).contains(&month) || !(1..=31).contains(&day) || !(0..=9999).contains(&year) {
        return None;
    }
    // Years are counted from March, so that the leap day is the last day of a year.
    let (years, months) = if month > 2 { (year, month - 3) } else { (year - 1, month + 9) };
    let (era, of_era) = (years.div_euclid(400), years.rem_euclid(400));
    let of_year = (153 * months + 2) / 5 + day - 1;
    Some(146_097 * era + 365 * of_era + of_era / 4 - of_era / 100 + of_year - 719_468)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_and_times_of_day() {
        assert_eq!(seconds("12:05:01.25"), Some(43_501.25));
        assert_eq!(seconds("2001-09-09 01:46"), Some(1e9 - 40.0));
        assert_eq!((seconds("05:12.25"), seconds("05:12,25")), (Some(312.25), Some(312.25)));
        assert_eq!(seconds("75:00.5"), Some(4500.5));
        assert_eq!((seconds("05:12"), is_ambiguous("05:12")), (None, true));
        assert!(!is_ambiguous("5:12:01") && !is_ambiguous("5:75") && !is_ambiguous("5"));
        // Known Unix times, seconds from 1970.
        assert_eq!(seconds("2001-09-09T01:46:40Z"), Some(1e9));
        assert_eq!(seconds("2001-09-09 01:46:40,500+02:00"), Some(1e9 + 0.5));
        assert_eq!(seconds("9.9.2001 01:46:40"), Some(1e9));
        assert_eq!(seconds("02/13/2009 23:31:30"), Some(1_234_567_890.0));
        assert_eq!(seconds("13/02/2009 23:31:30"), Some(1_234_567_890.0));
        let step =
            seconds("2024-03-01 00:00:00").unwrap() - seconds("2024-02-28 00:00:00").unwrap();
        assert_eq!(step, 2.0 * 86_400.0);
        for text in [
            "",
            "x",
            "12",
            "25:00:00",
            "12:61",
            "12:61:00",
            "1:2:3:4",
            "2024-13-45 1:00",
            "1-2 12:00",
        ] {
            assert_eq!(seconds(text), None, "{text}");
        }
    }
}
