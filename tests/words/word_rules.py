"""Rules for plain English sentences: word lists, inverted openings, numbers, length."""

from __future__ import annotations

import re
from collections.abc import Container
from types import MappingProxyType

MAX_WORDS = 24  # of a sentence; the median is to be 14 at most
MASK = "x"  # in place of code, formulas and places for values, each counted as one word

MASKED = re.compile(r"\$\$.+?\$\$|\$[^$\n]+\$|`[^`\n]+`|\[\[\w+(?::[^\]]*)?\]\]|https?://\S+|doi:\S+|(?<!\{)\{[a-z_]\w*(?:[:!][^{}]*)?\}",
                    re.S)
LINK = re.compile(r"!?\[([^\]\n]*)\]\([^)\n]*\)")
TAG = re.compile(r"</?[A-Za-z][^<>]*>")
WORD = re.compile(r"[^\W\d_][\w'’-]*")

PERSON = (r"(?:I|we|you|they|she|he|who|people|somebody|someone|nobody|everybody|everyone|anyone|anybody|students?|teachers?|persons?|"
          r"readers?|learners?|lecturers?|presenters?|followers?|newcomers?|audience|engineers?|examiners?|class|not|to|do|don’t|can)")
SENSOR = r"(?:sensors?|encoders?|radar)"  # may see, as instruments do


ADVERB = r"(?:always |never |only |also |still |then |now |already |hardly )?"


def _one(verb: str, but: str = "x{9}") -> str:
    """A verb of the mind whose subject, the word before it, is no person: the filter believes, x never hears."""
    return rf"(?<!\w)(?!(?:{PERSON}|{but})\b)[\w’)-]+ {ADVERB}{verb}\b"


def _several(verb: str, but: str = "x{9}") -> str:
    """The same of several things: filters believe."""
    return rf"(?<!\w)(?!(?:{PERSON}|{but})\b)(?:[\w’-]+s|both|two|all) {ADVERB}{verb}\b"


def _may(verb: str, but: str = "x{9}") -> str:
    """The same behind a helping verb: filters do not hear."""
    return rf"(?<!\w)(?!(?:{PERSON}|{but})\b)[\w’)-]+ (?:does|do|did|cannot|can|could|will|would|must|need) (?:not )?{ADVERB}{verb}\b"


PATTERNS: MappingProxyType[str, tuple[str, ...]] = MappingProxyType({
    "a thing acts like a person": (
        _one("(?:believes|believed|forgives|forgave|promises|promised|knows|knew|hears|heard|trembles|owes)"),
        _one("(?:wants|hopes|thinks|listens|notices|feels|fears|lied|lies(?=[.,;:!?]|$))"),
        _several("(?:believe|forgive|promise|know|hear|tremble|owe|want|hope|think|listen(?! on)|notice|feel|fear|lie(?=[.,;:!?]|$))"),
        _may("(?:believe|forgive|promise|know|hear|tremble|owe|want|hope|listen(?! on)|notice|feel|fear)"),
        _one("(?:claims|claimed|forgets|forgot|remembers|cares|sees)", SENSOR), _several("(?:claim|forget|remember|care|see)", SENSOR),
        _may("(?:claim|forget|remember|care|see)", SENSOR), r"\b(?:believing|believed|forgotten|blind|a lie|surviv\w+)\b",
        r"\b(?:is|are|was|were|observers?|controllers?|filters?) (?:not |still |all |never )?told\b",
        r"\b(?:is|are|was|were|been|being|be) (?:heard|believed|forgiven|promised|owed|told|accused|deaf|silent)\b",
        r"\b(?:lying|dishonest|honest(?:ly)?|innocent|guilty|accus\w+|liars?|witness(?:es)?|deaf|shy|bold|timid)\b(?! (?:on|in|at)\b)",
        r"\b(?:sensors?|filters?|observers?|models?|readings?|pages?) (?:that )?(?:lies?|lied)\b(?! (?:in|on|at|between|within|near|above|"
        r"below|outside|inside|along|beyond|under)\b)",
        r"\b(?:its|their|the \w+’s) promises?\b", r"\blives? by (?:it|them)sel(?:f|ves)\b", r"\blife of its own\b",
        r"\blisten(?:s|ing|ed)?\b(?! on)",
        r"\b(?:left|leave|leaves) to (?:it|them)sel(?:f|ves)\b", r"\b(?:rounding|noise|sensor|filter|it) will (?:feel|hear|know)\b",
        r"\bsays? no\b", r"\blets? (?:nothing|everything|no \w+) through\b", r"\bhas (?:no|a|its) say\b", r"\bwithout a say\b",
    ),
    "an idiom": (
        r"\b(?:die|dies|died|dying) (?:out|away|down)\b", r"\bin vain\b", r"\b(?:alive|dear|twins?)\b", r"\b(?:keep|stay|remain)s? quiet\b",
        r"\bmend(?:s|ed|ing)?\b", r"\bbears?\b(?= (?:a|an|the|it|its|no|any|delays?|gains?|less|more|only|\d|x\b)|[.,;:]|$)", r"\bborne\b",
        r"\b(?:comes?|is|are) (?:not )?home\b",
        r"\bbolted\b", r"\b(?:fall|falls|fell) silent\b", r"\b(?:stays?|sensor is|remains?) silent\b",
        r"\bon (?:its|their) side\b", r"\b(?:paid|pays?) (?:once|for|per|twice)\b", r"\bloud(?:ly|er|est)?\b", r"\banew\b",
        r"\bget(?:s)? there\b", r"\bdeparts?\b(?! from)", r"(?:^|[/;,] ?|\b(?:it|run|loop|error|that) )settles(?=[ ]?[./;,]|$)",
        r"(?:\d|\bx) long\b", r"\btold of\b", r"\btold the (?:wish|truth)\b", r"\bthe wish\b", r"\bmay be lost\b",
        r"% may be\b(?=[.,;]|$)", r"\bor one\?", r"\btakes? most out of\b", r"\b(?:is|are|was|were) to (?:be|have|do|go|come|stay|stand)\b",
        r"\b(?:no|what) man\b", r"\bby heart\b", r"\bby the hand\b", r"\bunder the hand\b", r"\bfollows? the hand\b", r"\bhas its way\b",
        r"\bat a stroke\b", r"\bsurprises?\b(?=[.,;]|$)", r"\ball but\b", r"\bshall\b", r"\btill\b",
        r"\bupon\b", r"\bwhereof\b", r"\bthereof\b", r"\bnought\b", r"\bere\b", r"\bsave for\b", r"\bbe it\b",
        r"^(?:caught|lost|gone)\.", r"\bpromised by\b", r"\b(?:taken|take it) at its word\b", r"\b(?:is|are) (?:not )?left alone\b",
        r"\bsaves? the (?:pole|estimate|loop|run)\b", r"\bcolour in the\b", r"\bwhat was colour\b", r"\banswered with no\b",
        r"\bdoubts? too\b", r"\bis content\b", r"\bfinds? (?:it|the filter|them) out\b",
        r"\bgives? (?:it|the \w+) away\b",
        r"^\w+ lies from\b", r"\bnames nobody\b", r"\bin this world\b", r"\bnothing to feel\b", r"\btakes? hold\b(?! of)",
        r"\bstill speaks?\b", r"\bon the bolt\b", r"\bnot dearer\b", r"\brounding, nothing else\b",
        r"\b(?:nothing|not) but\b", r"\bat the bottom of\b", r"\bbecomes? of\b", r"\bcomes? to (?:the same|nothing)\b",
    ),
    "an inverted opening": (
        r"^Of (?!course\b)", r"^(?:What|Whoever|Who|Whose|Whom|Whichever) [^?]*[.;:!]$",
        r"^That (?:the|a|an|it|they|no|every|one|its|x) ",
        r"^(?:Never|Seldom|Rarely|Hardly|Nor|Neither) (?:is|are|does|do|has|have|can|was)\b",
        r"^(?:Only|Not) [^,.]{2,40} (?:is|are|does|do|has|have|can|was|were) (?:the|a|an|it|its|one|there|this)\b",
        r"^So (?:is|are|does|do|did|has|have|would|will|can|it would|it is|was|were)\b",
        r"^(?:Such|Gone|Left|Lost|Long|Large|Small|Worse|Better) (?:is|are|was|were) (?:the|a|an|its|what)\b",
        r"^(?:Were|Had|Should) (?:the|a|an|it|its|one|there|x)\b[^?]*$",
        r"^(?:In|On|At|Under|Over|Above|Below|Behind|Beside|Between|Along|To|With|From|By|Through|Out of|Around)\b[^,.;:?]{2,50}? (?:"
        r"stands?|lies?|goes|comes|hangs?|sits?|belongs?|leads?|follows?|remains?|"
        r"stays?) (?:a|an|the|no|what|nothing|one|its|their|two|three)\b",
    ),
    "words to decode": (
        r"\bthat which\b", r"\bwhat is so\b", r"\bwhat (?:is|are|was) (?:measured|really|said|told|seen) (?:of|so)\b", r"\bof which\b",
        r"\bwhose turn\b", r"\bto whom\b", r"\bwith whom\b", r"\ban errand\b", r"\bwhat trusts\b",
        r"\b(?:filter|sensor|loop|observer|controller|regulator|one|those|pole|gain|run)s? who\b",
        r"\bwho (?:takes|gives|gains|wins|loses|stays|settles|errs|leads|holds)\b",
        r"^Who(?:se)? (?:is|are|takes|wins|gives|leads|sees|errs|has)\b", r"\bwhich \w+ the \w+ (?:is|are) to\b",
    ),
    "a number as a computer writes it": (
        r"(?<![\w.])\d+(?:\.\d+)?[eE][+−-]?\d", r"(?:^|[\s(=≈±,…])-\.?\d", r"(?<![\d.,])\d{4,}(?:[.,]\d+)? ?%",
        r"\d[\d.,]*·10[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+ ?%",
        r"\b10[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+ ?%", r"[−-][\d.·⁰¹²³⁴⁵⁶⁷⁸⁹⁻]+ ?% (?:larger|smaller|more|less|higher|lower|longer|shorter|better|worse)\b",
        r"\d{1,3}(?:,\d{3})+ ?%", r"[+−-] ?[+−-]\d",
    ),
    "a blank where a unit is missing": (r"\S [.;](?:\s|$)", r"\S ,\s", r"\(\s*\)", r"\[\s*\](?!\()"),
})
RULES = tuple((name, tuple(re.compile(pattern) for pattern in patterns)) for name, patterns in PATTERNS.items())
NUMBERS = "a number as a computer writes it"  # allowed in a script, which is ASCII
FOLDED = ("a thing acts like a person", "an idiom", "words to decode")  # rules that read a capital letter as a small one


def masked(sentence: str) -> str:
    """The sentence with x in place of code, formulas, places for values and addresses, and without marks of Markdown."""
    plain = TAG.sub("", MASKED.sub(MASK, LINK.sub(r"\1", sentence)).replace("{{", "{").replace("}}", "}"))
    return re.sub(r"\*\*|(?<!\w)\*(?=\w)|(?<=\S)\*(?!\w)", "", plain)


def word_count(sentence: str) -> int:
    """Words of a sentence; a formula, a piece of code and a place for a value count as one."""
    return len(WORD.findall(masked(sentence)))


def offences(sentence: str, allowed: Container[str] = ()) -> list[str]:
    """What is wrong with a sentence, one phrase for each find: the rule and the words found. `allowed` names rules that do not count."""
    plain = masked(sentence).strip()
    found = [f"{name}: {hit[0].strip()}" for name, patterns in RULES if name not in allowed for pattern in patterns
             if (hit := pattern.search(_lowered(plain) if name in FOLDED else plain))]
    count = word_count(sentence)
    return found + [f"{count} words, {MAX_WORDS} at most"] * (count > MAX_WORDS)


def _lowered(plain: str) -> str:
    return plain[:1].lower() + plain[1:] if plain[:2] != "I " else plain
