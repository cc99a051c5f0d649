"""A result as tables, texts and the content of its page. Read ``tables``, then ``summary`` and ``page_report``."""
