"""The closed forms that the papers print, corrected, where the package offers them.

``residue_form`` has the modal sums of Hauksdottir and Sigurdsson, ``normal_form_rows`` the transformations of Mayet.
"""
