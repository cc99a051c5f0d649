"""From files to plain tables. Read ``reading``, then ``includes``; ``messages`` knows the place of every entry."""
